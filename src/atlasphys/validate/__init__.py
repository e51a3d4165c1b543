"""Physical validation: cases with known answers."""
