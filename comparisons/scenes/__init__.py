"""What features know of one scene, in a folder for each."""
