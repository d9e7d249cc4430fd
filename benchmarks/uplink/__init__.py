"""How long the pictures and the sound of an application take until they are decoded: our receiver beside aiortc's."""
