"""Delay of an application's pictures and sound until they are decoded: our receiver beside aiortc's."""
