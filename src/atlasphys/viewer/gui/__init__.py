"""The page: one file per concern. Each part is made with the page, changes the world by queued commands only, and is refreshed by the page's thread."""
