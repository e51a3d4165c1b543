"""The algorithm explorer: every step of every stage, on a page in the browser."""
