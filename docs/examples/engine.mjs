// A game engine in JavaScript, without any library: a ball with an eye that goes where it is sent, and nods by hopping.
// `openrois demo --engine external` and `node docs/examples/engine.mjs` show it on the page.
import net from "node:net";

const WIDTH = 320, HEIGHT = 180, FPS = 30, NOD_SECONDS = 0.8, HOLD_SECONDS = 0.45, TURNING = 3;
const HELLO = 1, WELCOME = 2, VIDEO = 3, COMMAND = 5, EVENT = 6, BYE = 7;

const now = () => process.hrtime.bigint(); // CLOCK_MONOTONIC in ns, on Linux
const clamp = (value, most) => Math.min(most, Math.max(-most, value));
const turned = (angle) => Math.atan2(Math.sin(angle), Math.cos(angle));

const figure = { x: 0, y: 0, th: -Math.PI / 2, nod: null, walk: null, drive: null };

function message(type, ...payload) {
  const header = Buffer.from("ORL1\0\0\0\0\0\0\0\0\0\0\0\0");
  header[4] = type;
  header[5] = 1;
  header.writeUInt32LE(payload.reduce((sum, part) => sum + part.length, 0), 8);
  return Buffer.concat([header, ...payload]);
}

const say = (link, type, body) => link.write(message(type, Buffer.from(JSON.stringify(body))));
const completed = (link, id, status) => say(link, EVENT, { event: "completed", id, status });

function end(link, what, status) {
  if (figure[what]) completed(link, figure[what].id, status);
  figure[what] = null;
}

function obey(link, body) {
  switch (body.command) {
    case "react":
      end(link, "nod", "ABORT");
      if (body.reaction === "nod") figure.nod = { id: body.id, left: NOD_SECONDS };
      else completed(link, body.id, "ERROR");
      break;
    case "stop":
      if (body.id === null || body.id === figure.nod?.id) end(link, "nod", "ABORT");
      break;
    case "walk":
      end(link, "walk", "ABORT");
      figure.drive = null;
      figure.walk = { id: body.id, path: body.path, speed: body.speed, index: 0 };
      break;
    case "drive":
      end(link, "walk", "ABORT");
      figure.drive = { ...body, left_seconds: HOLD_SECONDS };
      break;
    case "halt":
      end(link, "walk", "ABORT");
      figure.drive = null; // and every other command is one for parts that this figure has not
      break;
    case "quit":
      process.exit();
  }
}

function move(link, seconds) {
  if (figure.nod && (figure.nod.left -= seconds) <= 0) end(link, "nod", "OK");
  if (figure.drive) {
    const { ahead, left, turn } = figure.drive;
    figure.x += (ahead * Math.cos(figure.th) - left * Math.sin(figure.th)) * seconds;
    figure.y += (ahead * Math.sin(figure.th) + left * Math.cos(figure.th)) * seconds;
    figure.th = turned(figure.th + turn * seconds);
    if ((figure.drive.left_seconds -= seconds) <= 0) figure.drive = null;
  } else if (figure.walk) {
    const [x, y, th] = figure.walk.path[figure.walk.index];
    const way = Math.hypot(x - figure.x, y - figure.y);
    const share = Math.min(1, (figure.walk.speed * seconds) / Math.max(way, 1e-9));
    const facing = th !== null && way < 0.3 ? th : way > 1e-6 ? Math.atan2(y - figure.y, x - figure.x) : figure.th;
    const off = turned(facing - figure.th);
    figure.th = turned(figure.th + clamp(off, TURNING * seconds));
    figure.x += (x - figure.x) * share;
    figure.y += (y - figure.y) * share;
    if (share === 1 && (th === null || Math.abs(off) < 0.01)) {
      say(link, EVENT, { event: "reached", id: figure.walk.id, index: figure.walk.index });
      if (++figure.walk.index === figure.walk.path.length) end(link, "walk", "OK");
    }
  }
}

function draw() {
  const luma = Buffer.alloc(WIDTH * HEIGHT, 60), chroma = Buffer.alloc((WIDTH * HEIGHT) / 2, 128);
  const hop = figure.nod ? 15 * Math.abs(Math.sin((figure.nod.left / NOD_SECONDS) * 2 * Math.PI)) : 0;
  const size = 30 / (1 + Math.max(-0.5, figure.y) / 4);
  const middle = WIDTH / 2 + 50 * figure.x, ground = HEIGHT - 40 - 15 * figure.y - hop;
  for (let row = 0; row < HEIGHT; row++) {
    for (let column = 0; column < WIDTH; column++) {
      const away = Math.hypot(column - middle, row - ground) / size;
      const eye = Math.hypot(column - middle - 0.7 * size * Math.cos(figure.th), row - ground + 4) / size;
      if (away < 1) luma[row * WIDTH + column] = eye < 0.2 ? 16 : 200 - 60 * away;
    }
  }
  return [luma, chroma];
}

function video(sequence, moment) {
  const head = Buffer.alloc(40);
  head.writeBigUInt64LE(BigInt(sequence), 0);
  head.writeBigUInt64LE(moment, 8);
  [WIDTH, HEIGHT, WIDTH, 2].forEach((number, index) => head.writeUInt32LE(number, 16 + 4 * index));
  return message(VIDEO, head, ...draw());
}

function connect() {
  const place = process.env.OPENROIS_LINK_ADDRESS ?? "tcp:127.0.0.1:8766";
  const [host, port] = [place.slice(4, place.lastIndexOf(":")), place.slice(place.lastIndexOf(":") + 1)];
  const link = net.connect(place.startsWith("unix:") ? { path: place.slice(5) } : { host, port: Number(port), noDelay: true });
  let unread = Buffer.alloc(0), clock = null, sequence = 0, last = now(), told = "", wanted = true;
  link.on("connect", () => {
    const shape = { width: WIDTH, height: HEIGHT, fps: FPS, format: "i420" };
    const secret = process.env.OPENROIS_LINK_SECRET ?? "";
    say(link, HELLO, { name: "ball", version: "1", secret, video: shape, audio: null, reactions: ["nod"], walks: true, demand: true });
  });
  link.on("data", (data) => {
    unread = Buffer.concat([unread, data]);
    while (unread.length >= 16 && unread.length >= 16 + unread.readUInt32LE(8)) {
      const type = unread[4], end = 16 + unread.readUInt32LE(8);
      const body = JSON.parse(unread.subarray(16, end)); // this engine never says `hears`: there is no AUDIO
      unread = unread.subarray(end);
      if (type === WELCOME) clock = setInterval(tick, 1000 / FPS);
      else if (type === COMMAND && body.command === "demand") want(body.consumers > 0);
      else if (type === COMMAND) obey(link, body);
      else if (type === BYE) console.log(`the adapter says goodbye: ${body.reason}`);
    }
  });
  function want(on) {
    const woken = on && !wanted;
    wanted = on;
    if (woken) tick(); // the first picture does not wait for its turn
  }
  function tick() {
    const moment = now();
    move(link, Number(moment - last) / 1e9);
    last = moment;
    const { x, y, th } = figure;
    if (sequence % 2 === 0 && `${[x, y, th]}` !== told) { // at most 20 a second
      say(link, EVENT, { event: "place", x, y, th });
      told = `${[x, y, th]}`;
    }
    if (!wanted) {
      if (sequence % (FPS / 2) === 0) say(link, EVENT, { event: "idle" }); // it draws nothing, and lives
    } else if (link.writableLength === 0) link.write(video(sequence, moment)); // what cannot be sent in time is left out
    sequence++;
  }
  link.on("error", (error) => console.log(error.message));
  link.on("close", () => {
    clearInterval(clock);
    Object.assign(figure, { nod: null, walk: null, drive: null });
    setTimeout(connect, 1000);
  });
}

connect();
