import { expect, it } from "vitest";
import { decodableCodecs } from "../../sdk/media/codecs.ts";

const h264 = (format: string) => ({ mimeType: "video/H264", sdpFmtpLine: format });

it("puts H.264 and VP8 first, and leaves out what is no codec", () => {
  const capabilities = [
    { mimeType: "video/VP8" },
    { mimeType: "video/rtx" },
    { mimeType: "video/AV1" },
    h264("level-asymmetry-allowed=1;packetization-mode=1;profile-level-id=42e01f"),
    h264("level-asymmetry-allowed=1;packetization-mode=1;profile-level-id=42001f"),
    { mimeType: "video/red" },
    { mimeType: "video/ulpfec" },
    { mimeType: "video/flexfec-03" },
  ];
  expect(decodableCodecs("video", capabilities)).toEqual(["video/H264", "video/VP8", "video/AV1"]);
});

it.each([["packetization-mode=0;profile-level-id=42e01f"], ["packetization-mode=1;profile-level-id=64001f"]])(
  "does not count H.264 with %s alone",
  (format) => {
    expect(decodableCodecs("video", [h264(format)])).toEqual([]);
  },
);

it("keeps Opus of the audio codecs in front", () => {
  const capabilities = ["audio/G722", "audio/CN", "audio/opus", "audio/telephone-event"].map((mimeType) => ({
    mimeType,
  }));
  expect(decodableCodecs("audio", capabilities)).toEqual(["audio/opus", "audio/G722"]);
});
