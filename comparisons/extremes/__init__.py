"""How far engines can be pushed, and who notices when they break."""
