// Runs in the page before its own scripts: reads picture and sound by means of its own, and counts peer connections.
// Tests read `probe`; the page does not know of it.
(() => {
  const CELLS = 80;
  const KEPT = 3000;
  const clock = performance.now.bind(performance);
  const probe = {
    // The newest frames that the page's video has presented: number and time of the stamp, mean luma, when (ms), when the
    // page takes it to be visible, and its RTP timestamp.
    frames: [],
    presented: 0,
    unreadable: 0,
    // Peer connections of the page, in the order of their making.
    connections: [],
    // What the Content-Security-Policy refused.
    violations: [],
    // What `watch` has seen, by name.
    watched: {},
    // Sound: when (ms), root mean square, and amplitude at 1 kHz.
    sound: [],
    // Commands that completed and words that were spoken: when the page was told (ms), and the params.
    told: [],
  };
  const watchers = new Map();
  globalThis.probe = probe;
  document.addEventListener("securitypolicyviolation", (event) =>
    probe.violations.push(`${event.effectiveDirective}: ${event.blockedURI}`),
  );

  if (globalThis.RTCPeerConnection) {
    globalThis.RTCPeerConnection = class extends RTCPeerConnection {
      constructor(...options) {
        super(...options);
        probe.connections.push(this);
      }
    };
  }

  globalThis.WebSocket = class extends WebSocket {
    constructor(...options) {
      super(...options);
      this.addEventListener("message", ({ data }) => {
        if (!/"rois\.command\.completed"|"word_spoken"/.test(data)) return;
        const { method, params } = JSON.parse(data);
        if (method) probe.told.push({ at: clock(), method, params });
        if (probe.told.length > KEPT) probe.told.shift();
      });
    }
  };

  // Resolves with what `condition` returns once that is true; looks every 25 ms.
  probe.until = (condition, patience) =>
    new Promise((resolve, reject) => {
      const end = clock() + patience;
      const look = () => {
        const found = condition();
        if (found) resolve(found);
        else if (clock() > end) reject(new Error(`not so within ${patience} ms: ${condition}`));
        else setTimeout(look, 25);
      };
      look();
    });

  const canvas = (width, height) => {
    const context = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
    return (source, x, y, w, h) => {
      context.drawImage(source, x, y, w, h, 0, 0, width, height);
      return context.getImageData(0, 0, width, height).data;
    };
  };
  const luma = (pixels, at) => 0.299 * pixels[at] + 0.587 * pixels[at + 1] + 0.114 * pixels[at + 2];
  const strip = canvas(CELLS * 8, 8);
  const thumb = canvas(32, 18);

  // 80 bits: 1010, 24 of the number, 44 of the wall time in 0.1 ms, CRC-8 (0x07) of those 68.
  const readStamp = (video) => {
    const rows = Math.max(8, Math.floor((video.videoHeight * 8) / 360));
    const pixels = strip(video, 0, video.videoHeight - rows, video.videoWidth, rows);
    let bits = 0n;
    for (let cell = 0; cell < CELLS; cell++) {
      let sum = 0;
      for (let y = 2; y < 6; y++) {
        for (let x = cell * 8 + 2; x < cell * 8 + 6; x++) sum += luma(pixels, 4 * (y * CELLS * 8 + x));
      }
      bits = (bits << 1n) | (sum >= 16 * 128 ? 1n : 0n);
    }
    const body = (bits >> 8n) & ((1n << 68n) - 1n);
    let crc = 0;
    for (let shift = 64n; shift >= 0n; shift -= 8n) {
      crc ^= Number((body >> shift) & 0xffn);
      for (let bit = 0; bit < 8; bit++) crc = ((crc << 1) ^ (crc & 0x80 ? 0x107 : 0)) & 0xff;
    }
    if (bits >> 76n !== 0b1010n || crc !== Number(bits & 0xffn)) return null;
    return { number: Number(body >> 44n), time: Number(body & ((1n << 44n) - 1n)) / 10 };
  };

  // Mean luma of what the video shows now, without the stamp's rows.
  probe.luma = () => {
    const video = probe.video;
    const pixels = thumb(video, 0, 0, video.videoWidth, (video.videoHeight * 340) / 360);
    let sum = 0;
    for (let at = 0; at < pixels.length; at += 4) sum += luma(pixels, at);
    return sum / (pixels.length / 4);
  };

  // Watches a part of the picture (fractions of its width and height) from now on. For every frame: how much it
  // differs from the one before (`step`) and from the first (`away`), in luma, mean over the part.
  probe.watch = (name, left, top, width, height) => {
    const see = canvas(48, 27);
    const samples = [];
    let first = null;
    let last = null;
    const difference = (one, other) =>
      one.reduce((sum, value, index) => sum + Math.abs(value - other[index]), 0) / one.length;
    probe.watched[name] = samples;
    watchers.set(name, (at) => {
      const { videoWidth: w, videoHeight: h } = probe.video;
      const pixels = see(probe.video, left * w, top * h, width * w, height * h);
      const now = Array.from({ length: pixels.length / 4 }, (_, index) => luma(pixels, 4 * index));
      first ??= now;
      samples.push({ at, step: difference(now, last ?? now), away: difference(now, first) });
      last = now;
    });
  };

  const presented = (now, { expectedDisplayTime, rtpTimestamp }) => {
    probe.video.requestVideoFrameCallback(presented);
    const stamp = readStamp(probe.video);
    if (!stamp) probe.unreadable += 1;
    const { number, time } = stamp ?? { number: null, time: null };
    probe.presented += 1;
    const visible = Math.max(now, Math.min(expectedDisplayTime, now + 50));
    probe.frames.push({ number, time, luma: probe.luma(), at: now, visible, rtp: rtpTimestamp });
    if (probe.frames.length > KEPT) probe.frames.shift();
    for (const watch of watchers.values()) watch(now);
  };

  // Listens to what the page's audio element plays. Needs a click in the page before.
  probe.listen = async () => {
    const audio = document.querySelector('[data-testid="avatar-audio"]');
    const context = new AudioContext({ sampleRate: 48000 });
    await context.resume();
    const analyser = new AnalyserNode(context, { fftSize: 1024, smoothingTimeConstant: 0 });
    const samples = new Float32Array(analyser.fftSize);
    let heard = null;
    let source = null;
    const hear = () => {
      const stream = audio.srcObject;
      if (stream && stream !== heard) {
        source?.disconnect();
        source = context.createMediaStreamSource(stream);
        source.connect(analyser);
        heard = stream;
      }
      analyser.getFloatTimeDomainData(samples);
      let energy = 0;
      let real = 0;
      let imaginary = 0;
      samples.forEach((sample, index) => {
        const angle = (2 * Math.PI * 1000 * index) / context.sampleRate;
        energy += sample * sample;
        real += sample * Math.cos(angle);
        imaginary += sample * Math.sin(angle);
      });
      const rms = Math.sqrt(energy / samples.length);
      const marker = (2 * Math.hypot(real, imaginary)) / samples.length;
      probe.sound.push({ at: performance.now(), rms, marker });
      if (probe.sound.length > KEPT) probe.sound.shift();
    };
    setInterval(hear, 10);
  };

  // When marker tones began: 1 kHz, and little else.
  probe.markers = () => {
    const begun = [];
    let last = -Infinity;
    for (const { at, rms, marker } of probe.sound) {
      const sounds = marker > 0.02 && marker / Math.SQRT2 > 0.7 * rms;
      if (sounds && at - last > 200) begun.push(at);
      if (sounds) last = at;
    }
    return begun;
  };

  // Milliseconds from a stamp's time, which is modulo 2^44 units of 0.1 ms, to a time of day.
  probe.since = (time, wall) => {
    const range = 2 ** 44 / 10;
    const passed = (((wall - time) % range) + range) % range;
    return passed > range / 2 ? passed - range : passed;
  };

  probe.median = (values) => values.toSorted((one, other) => one - other)[Math.floor(values.length / 2)];

  document.addEventListener("DOMContentLoaded", () => {
    probe.video = document.querySelector('[data-testid="avatar-video"]');
    probe.video?.requestVideoFrameCallback?.(presented);
  });
})();
