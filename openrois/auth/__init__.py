"""Authentication and authorization: tokens and their keys, principals with roles and scope."""
