"""The avatar as a streamer of Pixel Streaming: Epic's own page shows and operates it in the browser."""
