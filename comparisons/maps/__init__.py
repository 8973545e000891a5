"""Maps of a scene's motions over two of its parameters."""
