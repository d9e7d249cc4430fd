/** Which codecs this browser can decode and encode, in the order in which they are asked for. */

import type { MediaKind } from "../rois/generated/types.ts";

/** Cheapest to encode live and cheapest to decode first. */
const PREFERRED = ["video/h264", "video/vp8", "audio/opus"];

/** Not codecs of media but repair and comfort that travel beside them. */
const AUXILIARY = /\/(rtx|red|ulpfec|flexfec-03|CN|telephone-event)$/i;

interface CodecCapability {
  readonly mimeType: string;
  readonly sdpFmtpLine?: string;
}

/**
 * Returns MIME types, best first.
 *
 * H.264 counts only in the form that engines send: constrained baseline or baseline with packetization mode 1.
 */
export function decodableCodecs(
  kind: MediaKind,
  capabilities: readonly CodecCapability[] = RTCRtpReceiver.getCapabilities(kind)?.codecs ?? [],
): string[] {
  const usable = capabilities.filter((codec) => {
    if (AUXILIARY.test(codec.mimeType)) return false;
    if (codec.mimeType.toLowerCase() !== "video/h264") return true;
    const format = codec.sdpFmtpLine ?? "";
    return /packetization-mode=1/.test(format) && /profile-level-id=42/i.test(format);
  });
  const rank = (mimeType: string): number => {
    const index = PREFERRED.indexOf(mimeType.toLowerCase());
    return index < 0 ? PREFERRED.length : index;
  };
  return [...new Set(usable.map((codec) => codec.mimeType))].sort((a, b) => rank(a) - rank(b));
}

/** Returns MIME types of what can be sent, as `decodableCodecs` does; of these the engine has its pick. */
export function encodableCodecs(kind: MediaKind): string[] {
  return decodableCodecs(kind, RTCRtpSender.getCapabilities(kind)?.codecs ?? []);
}
