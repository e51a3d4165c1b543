"""Kinds of joints: what the user gives to ``World.join``, and of which parts each is made."""
