"""Speed against other engines, on the same scenes, counting only answers that are right."""
