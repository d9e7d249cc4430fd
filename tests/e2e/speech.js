// Runs in the page: an application that speaks through the avatar by sound, as the SDK lets it. Resolves with what tests
// use; they read `program`, of which the page does not know.
async (rate) => {
  const clock = performance.now.bind(performance);
  // Of each frame: samples of its speech that were sent with it, and those that the body had allowed by then.
  const frames = [];
  const steps = [];
  const sent = new Map();
  const granted = new Map();
  const make = RTCPeerConnection.prototype.createDataChannel;
  RTCPeerConnection.prototype.createDataChannel = function (label, options) {
    const channel = make.call(this, label, options);
    if (label !== "speech") return channel;
    program.channel = channel;
    const send = channel.send.bind(channel);
    channel.send = (data) => {
      if (typeof data !== "string" && program.counts) {
        const number = new DataView(data).getUint32(0);
        sent.set(number, (sent.get(number) ?? 0) + (data.byteLength - 8) / 2);
        frames.push({ number, sent: sent.get(number), granted: granted.get(number) ?? rate, at: clock() });
      }
      send(data);
    };
    channel.addEventListener("message", ({ data }) => {
      const told = JSON.parse(data);
      program.told.push(told);
      if (told.event === "credit") granted.set(told.utterance, Math.max(rate, told.samples));
    });
    return channel;
  };
  const program = (globalThis.program = { frames, steps, told: [], counts: true, channel: null });

  const { Client, MediaReceiver, SpeechStream } = await import("./openrois.js");
  const client = new Client("./");
  await client.connect();
  const media = new MediaReceiver(client, { input: true });
  await media.stream("avatar/audio_streaming", "audio").connect();
  await probe.until(() => media.inputs("avatar").length > 0, 30_000);
  const speech = new SpeechStream(client, media, "avatar/speech_stream", rate);
  for (const name of ["started", "starved", "finished"])
    speech.on(name, (value) => steps.push({ name, value, at: clock() }));
  await speech.start();

  // 1 kHz, which the probe tells from everything else.
  program.tone = (seconds, samplesPerSecond = rate) =>
    Float32Array.from(
      { length: Math.round(seconds * samplesPerSecond) },
      (_, index) => 0.5 * Math.sin((2 * Math.PI * 1000 * index) / samplesPerSecond),
    );
  // When the tone was heard since a moment: its first and its last millisecond; null for not at all.
  program.heard = (since) => {
    const loud = probe.sound.filter(
      ({ at, rms, marker }) => at > since && marker > 0.02 && marker / Math.SQRT2 > 0.7 * rms,
    );
    return loud.length === 0 ? null : [loud[0].at, loud.at(-1).at];
  };
  // Resolves when nothing has been heard for a while.
  program.quiet = () => probe.until(() => probe.sound.slice(-30).every(({ rms }) => rms < 0.005), 30_000);
  program.frame = (number, sequence, sound) => {
    const frame = new Uint8Array(8 + sound.length);
    new DataView(frame.buffer).setUint32(0, number);
    new DataView(frame.buffer).setUint32(4, sequence);
    frame.set(sound, 8);
    return frame;
  };
  // One packet of Opus for each 20 ms; null where this browser does not encode it.
  program.opus = async (samples) => {
    const config = { codec: "opus", sampleRate: 48_000, numberOfChannels: 1, bitrate: 32_000 };
    if (!globalThis.AudioEncoder || !(await AudioEncoder.isConfigSupported(config)).supported) return null;
    const packets = [];
    const output = (chunk) => {
      const data = new Uint8Array(chunk.byteLength);
      chunk.copyTo(data);
      packets.push(data);
    };
    const encoder = new AudioEncoder({ output, error: (error) => packets.push(error) });
    encoder.configure(config);
    const format = { format: "f32", sampleRate: 48_000, numberOfChannels: 1, timestamp: 0 };
    encoder.encode(new AudioData({ ...format, numberOfFrames: samples.length, data: samples }));
    await encoder.flush();
    return packets;
  };
  Object.assign(program, { client, speech });
};
