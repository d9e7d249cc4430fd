"""`openrois bench`: how long a picture takes to a viewer, and what each further viewer costs.

What is measured runs in processes of its own, on this machine; `command` starts them, asks them and ends them.
"""
