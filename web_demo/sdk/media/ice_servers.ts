/** The STUN and TURN servers of the gateway; their credentials are short-lived. */

import { METHOD_NOT_FOUND } from "../jsonrpc/peer.ts";
import type { JsonObject } from "../jsonrpc/peer.ts";
import { RpcError } from "../jsonrpc/session.ts";
import { listField } from "../rois/types.ts";

/** Credentials are fetched anew this long before they end, in seconds. */
const MARGIN = 30;

interface Caller {
  call(method: string, params?: JsonObject): Promise<JsonObject>;
}

export class IceServers {
  readonly #caller: Caller;
  #servers: RTCIceServer[] = [];
  #staleAt = 0;
  #asking: Promise<void> | null = null;

  constructor(caller: Caller) {
    this.#caller = caller;
  }

  get current(): RTCIceServer[] {
    return this.#servers;
  }

  /** Asks the gateway, unless what it said still holds. A gateway without such servers is fine. */
  refresh(): Promise<void> {
    if (performance.now() < this.#staleAt) return Promise.resolve();
    this.#asking ??= this.#ask().finally(() => {
      this.#asking = null;
    });
    return this.#asking;
  }

  /** Another session may have another gateway behind it. */
  forget(): void {
    this.#staleAt = 0;
  }

  async #ask(): Promise<void> {
    try {
      const result = await this.#caller.call("signaling.ice_servers");
      const ttl = typeof result["ttl"] === "number" ? result["ttl"] : 0;
      this.#servers = listField<RTCIceServer & JsonObject>(result, "ice_servers");
      this.#staleAt = performance.now() + 1000 * Math.max(0, ttl - MARGIN);
    } catch (error) {
      if (!(error instanceof RpcError && error.code === METHOD_NOT_FOUND)) throw error;
      this.#servers = [];
    }
  }
}
