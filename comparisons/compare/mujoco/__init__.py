"""The script that other installations of MuJoCo run."""
