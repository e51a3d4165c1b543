"""Joints: constraint parts (``parts/``), and the kinds of joints that are composed of them (``kinds/``)."""
