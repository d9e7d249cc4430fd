"""The avatar as a streamer of Pixel Streaming: Epic's own page shows it in the browser, and operates it."""
