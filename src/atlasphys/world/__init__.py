"""Worlds, handles and views: they check what the user gives, call the engine, and wrap what it gives back. No physics is here."""
