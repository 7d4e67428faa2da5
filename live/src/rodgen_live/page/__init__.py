"""The page of the live view and its server (NiceGUI, from the extra `view`)."""
