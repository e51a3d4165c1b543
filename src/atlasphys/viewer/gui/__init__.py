"""The page: a file per concern. Each part changes the world by queued commands only, and is refreshed by the page's thread."""
