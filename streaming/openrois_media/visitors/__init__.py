"""Visitors: what applications send to a body, told apart, and used for what each consents to, and for nothing else."""
