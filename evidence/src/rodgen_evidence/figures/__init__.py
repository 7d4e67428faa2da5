"""The drawings of the model in the documentation, from the derivation itself."""
