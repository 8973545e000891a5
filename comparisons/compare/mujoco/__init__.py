"""What runs where MuJoCo is."""
