"""Distributions of the product: builds them, and tries each as a user would. Publishes nothing."""
