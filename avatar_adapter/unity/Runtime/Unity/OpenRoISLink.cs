using System;
using System.Collections;
using System.Collections.Generic;
using UnityEngine;

namespace OpenRoIS.Link.Unity
{
    /// <summary>
    /// Gives the pictures of a camera, and the sound that passes this object, to an avatar adapter, and tells on the
    /// main thread what the avatar shall do. Put it on the object with the AudioListener to send what the game sounds like.
    /// It connects by itself, again whenever the adapter went away, and never makes the game wait.
    /// </summary>
    [DefaultExecutionOrder(-1000)]
    [AddComponentMenu("OpenRoIS/OpenRoIS Link")]
    public sealed class OpenRoISLink : MonoBehaviour
    {
        [Header("Connection: empty for what an adapter that started this game has put into the environment")]
        [Tooltip("unix:/path or tcp:host:port, on this machine")]
        public string Address = "";
        public string Secret = "";

        [Header("Pictures")]
        [Tooltip("A camera for the viewers alone, beside the player's: it draws into a texture of this component")]
        public Camera Source;
        public int Width = 1280;
        public int Height = 720;
        public float PicturesPerSecond = 30f;

        [Tooltip("Whether the lowest row of the texture comes first when it is read back: see the README")]
        public bool BottomRowFirst = true;

        [Header("What the figure can do")]
        public string[] Reactions = new string[0];
        [Tooltip("Sends what passes OnAudioFilterRead of this object")]
        public bool SendsSound = true;
        [Tooltip("Wants the operator's voice: Heard")]
        public bool Hears = true;
        [Tooltip("Obeys Walk, Drive and Halt, and tells Place: OpenRoISWalker does")]
        public bool Walks;
        [Tooltip("Takes Input: keyboard, mouse, touch and gamepad of the operator")]
        public bool TakesInput;
        [Tooltip("Ends the game when the adapter wants that")]
        public bool Quits = true;

        private LinkClient _client;
        private CameraPictures _pictures;
        private Picture _shape;
        private long _frameNs;
        private volatile SoundStream _sound;
        private volatile int _soundRate;
        private string _reason = "";

        /// <summary>An adapter is there, or gone; then nothing that was asked for needs an answer any more.</summary>
        public event Action Connected;
        public event Action<string> Disconnected;

        /// <summary>Play the reaction, then call Completed with the id.</summary>
        public event Action<string, string> React;

        /// <summary>
        /// Stop the reaction with this id, or every one if it is null; each is then Completed with Abort.
        /// </summary>
        public event Action<string> Stop;

        /// <summary>Move the mouth; OpenRoISMouth does it.</summary>
        public event Action<Speak> Speak;
        public event Action Silence;

        /// <summary>Look: x from -1 (the viewer's left) to 1, y from -1 (down) to 1.</summary>
        public event Action<float, float> Look;

        /// <summary>Move the figure; OpenRoISWalker does it.</summary>
        public event Action<Walk> Walk;
        public event Action<Drive> Drive;
        public event Action Halt;

        /// <summary>The operator's voice.</summary>
        public event Action<Heard> Heard;

        /// <summary>What the operator does: a message of docs/reference/wire.md, "Input".</summary>
        public event Action<OperatorInput> Input;

        /// <summary>The adapter wants the game to end; with Quits it does.</summary>
        public event Action Quit;

        /// <summary>Whether an adapter is there.</summary>
        public bool IsConnected
        {
            get { return _client != null && _client.IsConnected; }
        }

        /// <summary>Now, on the adapter's clock, in nanoseconds.</summary>
        public long Now
        {
            get { return _client == null ? 0 : _client.Now; }
        }

        /// <summary>What was asked for is over.</summary>
        public void Completed(string id, Status status)
        {
            _client?.Completed(id, status);
        }

        /// <summary>The figure has reached that point of a Walk.</summary>
        public void Reached(string id, int index)
        {
            _client?.Reached(id, index);
        }

        /// <summary>Where the figure is: call it as often as you like.</summary>
        public void Place(Vector3 position, Quaternion rotation)
        {
            FloorPoint at = Coordinates.ToLink(position.x, position.z);
            _client?.Place(at.X, at.Y, Coordinates.ToTh(rotation.eulerAngles.y));
        }

        /// <summary>Where the figure can go: polygons in the world's x and z.</summary>
        public void Floor(IList<Vector3> outline, IList<IList<Vector3>> obstacles)
        {
            List<IList<FloorPoint>> inside = new List<IList<FloorPoint>>();
            foreach (IList<Vector3> obstacle in obstacles)
            {
                inside.Add(Polygon(obstacle));
            }
            _client?.Floor(Polygon(outline), inside);
        }

        /// <summary>All there is beside the figure: call it as often as you like.</summary>
        public void Things(IList<Thing> things)
        {
            _client?.Things(things);
        }

        /// <summary>Something in the scene, as Things takes it.</summary>
        public static Thing ThingAt(string id, ThingKind kind, string name, Transform at)
        {
            FloorPoint place = Coordinates.ToLink(at.position.x, at.position.z);
            return new Thing(id, kind, name, place.X, place.Y, Coordinates.ToTh(at.rotation.eulerAngles.y));
        }

        /// <summary>The game pauses: viewers keep the last picture and are told so.</summary>
        public void Pause(bool on)
        {
            _client?.Pause(on);
        }

        /// <summary>A line for the adapter's log.</summary>
        public void Log(string text)
        {
            _client?.Log(text);
        }

        private void Awake()
        {
            if (string.IsNullOrEmpty(Address))
            {
                Address = Environment.GetEnvironmentVariable("OPENROIS_LINK_ADDRESS") ?? "tcp:127.0.0.1:8766";
                Secret = Environment.GetEnvironmentVariable("OPENROIS_LINK_SECRET") ?? Secret;
            }
            Application.runInBackground = true;
            try
            {
                _shape = Picture.Bgra(Width, Height, BottomRowFirst);
                _client = new LinkClient(Address, Greeting());
            }
            catch (LinkException error)
            {
                Debug.LogError("OpenRoISLink: " + error.Message);
                enabled = false;
            }
        }

        private void OnEnable()
        {
            if (Source == null || !SystemInfo.supportsAsyncGPUReadback)
            {
                string lack = Source == null ? "no camera" : "a graphics API without asynchronous read-back";
                Debug.LogError("OpenRoISLink: there are no pictures: " + lack);
                return;
            }
            _pictures = _pictures ?? new CameraPictures(Source, _shape, PicturesPerSecond, _client);
            StartCoroutine(TakePictures());
        }

        private void Start()
        {
            _soundRate = AudioSettings.outputSampleRate;
            if (SendsSound)
            {
                _sound = new SoundStream(2, (block, count, at) => _client.SendSound(block, count, 2, at));
            }
            _client.Start();
        }

        private void OnDestroy()
        {
            _sound = null;
            _client?.Close("the engine ends");
            _pictures?.Release();
        }

        private void Update()
        {
            Notice notice;
            while (_client.TryTake(out notice))
            {
                Tell(notice);
            }
            // The scene moves after this, for this moment: not for one before the picture was wanted.
            _frameNs = _client.Now;
            _pictures?.Draw(_client.PicturesWanted);
        }

        /// <summary>On the thread that mixes the sound.</summary>
        private void OnAudioFilterRead(float[] data, int channels)
        {
            SoundStream sound = _sound;
            if (sound != null && _client.IsConnected)
            {
                sound.Take(data, channels, _soundRate, _client.Now);
            }
        }

        private Hello Greeting()
        {
            return new Hello
            {
                Name = string.IsNullOrEmpty(Application.productName) ? "unity" : Application.productName,
                Version = Application.unityVersion,
                Secret = Secret,
                Width = Width,
                Height = Height,
                PicturesPerSecond = PicturesPerSecond,
                AudioChannels = SendsSound ? 2 : 0,
                Reactions = Reactions,
                Hears = Hears,
                Walks = Walks,
                Ring = true,
                TakesInput = TakesInput,
                TakesDemand = true
            };
        }

        private void Tell(Notice notice)
        {
            if (notice is Command)
            {
                TellCommand((Command)notice);
            }
            else if (notice is Heard)
            {
                Heard?.Invoke((Heard)notice);
            }
            else if (notice is Connected)
            {
                _reason = "";
                Connected?.Invoke();
            }
            else if (notice is Disconnected)
            {
                TellReason(((Disconnected)notice).Reason);
                Disconnected?.Invoke(_reason);
            }
            else
            {
                TellReason(((NotConnected)notice).Reason);
            }
        }

        private void TellReason(string reason)
        {
            if (reason != _reason)
            {
                _reason = reason;
                Debug.LogWarning("OpenRoISLink: " + reason);
            }
        }

        private void TellCommand(Command command)
        {
            React react = command as React;
            Stop stop = command as Stop;
            Look look = command as Look;
            if (react != null)
            {
                TellReaction(react);
            }
            else if (stop != null)
            {
                Stop?.Invoke(stop.Id);
            }
            else if (look != null)
            {
                Look?.Invoke((float)look.X, (float)look.Y);
            }
            else if (command is Speak)
            {
                Speak?.Invoke((Speak)command);
            }
            else if (command is Silence)
            {
                Silence?.Invoke();
            }
            else if (command is OperatorInput)
            {
                Input?.Invoke((OperatorInput)command);
            }
            else if (command is Quit)
            {
                TellQuit();
            }
            else
            {
                TellMotion(command);
            }
        }

        private void TellMotion(Command command)
        {
            Walk walk = command as Walk;
            if (walk != null && Walk == null)
            {
                Completed(walk.Id, Status.Error);
            }
            else if (walk != null)
            {
                Walk(walk);
            }
            else if (command is Drive)
            {
                Drive?.Invoke((Drive)command);
            }
            else if (command is Halt)
            {
                Halt?.Invoke();
            }
        }

        private void TellReaction(React react)
        {
            bool known = React != null && Array.IndexOf(Reactions, react.Reaction) >= 0;
            if (known)
            {
                React(react.Id, react.Reaction);
            }
            else
            {
                Completed(react.Id, Status.Error);
            }
        }

        private void TellQuit()
        {
            Quit?.Invoke();
            if (Quits)
            {
                _client.Close("the engine ends");
                Application.Quit();
            }
        }

        private IEnumerator TakePictures()
        {
            WaitForEndOfFrame drawn = new WaitForEndOfFrame();
            while (true)
            {
                yield return drawn;
                if (_client.IsConnected && _client.PicturesWanted)
                {
                    _pictures.Take(_frameNs);
                }
            }
        }

        private static List<FloorPoint> Polygon(IList<Vector3> corners)
        {
            List<FloorPoint> polygon = new List<FloorPoint>();
            foreach (Vector3 corner in corners)
            {
                polygon.Add(Coordinates.ToLink(corner.x, corner.z));
            }
            return polygon;
        }
    }
}
