/** What a stream is asked for: of the engine, and of a device. Pure. */

import type { Direction, Parameter, Purpose } from "../rois/generated/types.ts";
import type { EncodingLimits } from "./stream.ts";

/** Returns the parameters of `connect_stream`: JSON text each. */
export function streamParameters(
  codecs: readonly string[],
  limits: EncodingLimits,
  direction: Direction,
  input = false,
  consent: readonly Purpose[] | null = null,
): Parameter[] {
  const transport = { direction, ...(input && { input }), ...(consent !== null && { consent }) };
  return [
    jsonParameter("encoding_parameters", { codecs, ...limits }),
    jsonParameter("transport_parameters", transport),
  ];
}

/** What a device gives need not be more than what is sent of it. */
export function sizeWanted({ width, height, fps }: EncodingLimits): MediaTrackConstraints {
  return {
    ...(width !== undefined && { width: { ideal: width } }),
    ...(height !== undefined && { height: { ideal: height } }),
    ...(fps !== undefined && { frameRate: { ideal: fps } }),
  };
}

function jsonParameter(name: string, value: object): Parameter {
  return { name, data_type_ref: "string", value: JSON.stringify(value) };
}
