"""Who is at the other end of a connection, what that one may do, and how it is proven by a token."""
