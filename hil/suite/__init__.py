"""One list of scenes, and the targets that it is run on."""
