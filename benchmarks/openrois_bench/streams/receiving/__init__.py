"""What an application receives, from sent to decoded: `openrois_media.Media` beside plain aiortc."""
