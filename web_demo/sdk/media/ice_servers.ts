/** The STUN and TURN servers of the gateway; their credentials are short-lived. */

import { METHOD_NOT_FOUND } from "../jsonrpc/peer.ts";
import { RpcError } from "../jsonrpc/session.ts";
import type { IceServer } from "../rois/generated/types.ts";
import type { Call } from "../rois/link.ts";

/** Credentials are fetched anew this long before they end, in seconds. */
const MARGIN = 30;

interface Caller {
  readonly call: Call;
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

  /** Asks the gateway, unless the servers are still valid. A gateway may have none. */
  refresh(): Promise<void> {
    if (performance.now() < this.#staleAt) return Promise.resolve();
    this.#asking ??= this.#ask().finally(() => {
      this.#asking = null;
    });
    return this.#asking;
  }

  /** Marks the servers as expired: another session may reach another gateway. */
  expire(): void {
    this.#staleAt = 0;
  }

  async #ask(): Promise<void> {
    try {
      const { ice_servers: servers = [], ttl = 0 } = await this.#caller.call("signaling.ice_servers");
      this.#servers = servers.map(browserForm);
      this.#staleAt = performance.now() + 1000 * Math.max(0, ttl - MARGIN);
    } catch (error) {
      if (!(error instanceof RpcError && error.code === METHOD_NOT_FOUND)) throw error;
      this.#servers = [];
    }
  }
}

/** A browser wants a credential that is absent to be absent, not null. */
function browserForm({ urls, username, credential }: IceServer): RTCIceServer {
  return {
    urls: [...urls],
    ...(username != null && { username }),
    ...(credential != null && { credential }),
  };
}
