"""What MuJoCo tells of a model."""
