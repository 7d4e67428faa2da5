"""Steps of the methods in rodgen.model.methods: in Python, in C, and what chooses among them."""
