// A page with nothing on it but Epic's front-end of Pixel Streaming.
import { LogLevel, Logger } from "@epicgames-ps/lib-pixelstreamingcommon-ue5.5";
import {
  Config,
  Flags,
  NumericParameters,
  PixelStreaming,
  TextParameters,
} from "@epicgames-ps/lib-pixelstreamingfrontend-ue5.5";

Logger.InitLogging(LogLevel.Error, false);

window.told = [];
window.startedAt = Date.now();
const config = new Config({
  useUrlParams: false,
  initialSettings: {
    [TextParameters.SignallingServerUrl]: `ws://${location.host}/player`,
    [Flags.AutoConnect]: true,
    [Flags.AutoPlayVideo]: true,
    [Flags.StartVideoMuted]: true,
    [Flags.WaitForStreamer]: true,
    [Flags.KeyboardInput]: true,
    [Flags.MouseInput]: true,
    [Flags.TouchInput]: true,
    [Flags.GamepadInput]: true,
    [NumericParameters.MaxReconnectAttempts]: 20,
    [NumericParameters.StreamerAutoJoinInterval]: 200,
  },
});
window.player = new PixelStreaming(config, { videoElementParent: document.getElementById("stage") });
document.querySelector("video").dataset.testid = "avatar-video";
const names = ["initialSettings", "inputControlOwnership", "qualityControlOwnership", "latencyTestResult",
  "dataChannelLatencyTestResult", "dataChannelOpen", "webRtcDisconnected", "playStream"];
for (const name of names) {
  player.addEventListener(name, ({ data }) => told.push({ name, data: JSON.parse(JSON.stringify(data ?? {})) }));
}
