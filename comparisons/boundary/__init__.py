"""``boundary``: where periodic orbits lose their stability, as curves over two parameters."""
