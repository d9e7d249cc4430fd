"""Profiles in the standard's XML (XML-Profiles.xsd), written and read. Pure.

What the schema has no place for is carried where GML leaves room, so that a profile that was written reads back as it
was. Names that other readers know are used for everything else. docs/how-to/profiles.md says what stands where.
"""
