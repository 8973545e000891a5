"""MuJoCo as an adapter."""
