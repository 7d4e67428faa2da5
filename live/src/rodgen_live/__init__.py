"""The live view: a run in a thread, drawn in a browser, changed while it goes on."""
