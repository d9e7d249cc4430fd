"""A hundred thousand wrong messages, each answered by one right error, while another client works."""
