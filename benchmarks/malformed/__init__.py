"""A hundred thousand live messages that are all wrong, each answered by one right error, while somebody else works."""
