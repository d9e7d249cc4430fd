// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Threading;

namespace OpenRoIS
{
    /// <summary>How a client connects, and where its callbacks come.</summary>
    public sealed class ClientOptions
    {
        /// <summary>
        /// Returns the newest JSON Web Token (RFC 7519), where the gateway wants one. It is called at every connection, and
        /// before the present token ends, on a thread of the pool: what belongs to Unity's main thread it must not touch.
        /// The client waits for it. It may throw: that is a failed attempt, with its message.
        /// </summary>
        public Func<string> Token { get; set; }

        /// <summary>How long connecting may take.</summary>
        public TimeSpan ConnectTimeout { get; set; } = TimeSpan.FromSeconds(10);

        /// <summary>How long an answer may take.</summary>
        public TimeSpan RequestTimeout { get; set; } = TimeSpan.FromSeconds(30);

        /// <summary>After how long a silence the gateway is asked for a sign of life.</summary>
        public TimeSpan IdleProbe { get; set; } = TimeSpan.FromSeconds(20);

        /// <summary>When a lost connection is made again.</summary>
        public Reconnect Reconnect { get; set; } = new Reconnect();

        /// <summary>
        /// Where handlers of events are called: a <see cref="Dispatcher"/> in Unity. Without one it is the context in which
        /// the client is made, and where there is none a thread of the pool, for one handler at a time.
        /// </summary>
        public SynchronizationContext Callbacks { get; set; }

        /// <summary>
        /// Where the client does its own work. Without one it borrows threads of the pool; where there are none (WebGL) it
        /// is the same dispatcher, which is pumped.
        /// </summary>
        public SynchronizationContext Work { get; set; }

        /// <summary>Opens connections.</summary>
        public ITransport Transport { get; set; } = new WebSocketTransport();

        /// <summary>The clock of all waits.</summary>
        public ITiming Timing { get; set; } = SystemTiming.Instance;

        /// <summary>
        /// Takes what a handler of the application has thrown, which ends nothing; without one it is written to standard
        /// error. It is called on the thread of the handler.
        /// </summary>
        public Action<Exception> HandlerFailed { get; set; } =
            error => Console.Error.WriteLine("OpenRoIS: a handler has failed: " + error);

        /// <summary>Returns a copy with everything that a client needs.</summary>
        /// <exception cref="ArgumentException">an option cannot be</exception>
        internal ClientOptions Checked()
        {
            Require("Transport", Transport != null, "is null: leave it, or set one of your own");
            Require("Timing", Timing != null, "is null: leave it, or set one of your own");
            Require("HandlerFailed", HandlerFailed != null, "is null: what handlers throw would vanish");
            Require("Reconnect", Reconnect != null, "is null: leave it, or set waits of your own");
            RequireTime("ConnectTimeout", ConnectTimeout);
            RequireTime("RequestTimeout", RequestTimeout);
            RequireTime("IdleProbe", IdleProbe);
            RequireTime("Reconnect.First", Reconnect.First);
            RequireTime("Reconnect.Limit", Reconnect.Limit);
            Require("Reconnect.Factor", Reconnect.Factor >= 1, "is " + Reconnect.Factor + ": it must be at least 1");
            var checkedOptions = (ClientOptions)MemberwiseClone();
            Action<Exception> failed = HandlerFailed;
            checkedOptions.HandlerFailed = error => Failures.Report(failed, error);
            checkedOptions.Callbacks =
                Callbacks ?? SynchronizationContext.Current ?? new Strand(null, checkedOptions.HandlerFailed);
            return checkedOptions;
        }

        private static void RequireTime(string name, TimeSpan time)
        {
            bool holds = time >= TimeSpan.FromMilliseconds(1) && time <= TimeSpan.FromDays(1);
            Require(name, holds, "is " + time + ": it must be between a millisecond and a day");
        }

        private static void Require(string name, bool holds, string otherwise)
        {
            if (!holds)
            {
                throw new ArgumentException("ClientOptions." + name + " " + otherwise);
            }
        }
    }
}
