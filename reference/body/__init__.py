"""What scenes with a rigid body on a ball joint share: numbers, rotation, mistakes."""
