"""The hook of the documentation site's build, beside mkdocs.yml."""
