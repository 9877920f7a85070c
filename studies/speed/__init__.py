"""What a particle-step costs."""
