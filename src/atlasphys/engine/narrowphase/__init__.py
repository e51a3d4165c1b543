"""The narrow phase: from pairs of shapes that may touch to contact points."""
