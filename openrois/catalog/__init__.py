"""The component types of RoIS 2.0 as data: messages, typed values and parameters, each traceable to its source.

Profiles, client proxies, adapter base classes and the types of other languages are all derived from here. Where the
standard's files differ, XML beats IDL beats text, and the field says so.

Pure.
"""
