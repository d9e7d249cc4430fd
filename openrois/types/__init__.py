"""The data model of RoIS 2.0 as frozen Pydantic models: the single source of every type on the wire. Pure.

Conflicts between the standard's files are settled as XML before IDL before text.
"""
