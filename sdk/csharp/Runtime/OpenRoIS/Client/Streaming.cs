// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Threading;
using System.Threading.Tasks;
using Newtonsoft.Json.Linq;

namespace OpenRoIS.Components
{
    /// <summary>
    /// A component with streams, over the extension <c>rois.stream</c> where the gateway and the engine have it, and in
    /// strict RoIS elsewhere. Media do not pass through RoIS: <see cref="OpenRoIS.Media.MediaSession"/> negotiates them.
    /// </summary>
    public abstract class Streaming : RoISCommon
    {
        private const string Extension = "rois.stream";
        private const int LongestPlayout = 60000;

        protected Streaming(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        private bool IsExtended
        {
            get { return Client.Application.Extensions.Contains(Extension); }
        }

        /// <summary>Status changes of streams; a gateway with the extension reports this application's own.</summary>
        public ComponentEvent<StreamChange> NotifyStreamStatus
        {
            get
            {
                return Event("notify_stream_status", told => new StreamChange(
                    (string)told.Find("stream_id", "string"),
                    told.Enumerator<StreamStatus>("status"),
                    told.Moment("timestamp")));
            }
        }

        /// <summary>Connects a stream, and returns its id, which stands for it until it ends.</summary>
        /// <param name="encoding">what the application can decode: <c>new { codecs = new[] { "video/H264" } }</c>; null for all
        /// that the engine has. In strict RoIS it is the component's, for every application</param>
        /// <param name="transport">such as <c>new { direction = "recvonly" }</c>; null for that</param>
        /// <param name="token">gives up; a stream that comes then is disconnected</param>
        /// <exception cref="UnsupportedException">there is nothing that both sides can do</exception>
        public Task<string> ConnectStreamAsync(
            object encoding = null, object transport = null, CancellationToken token = default(CancellationToken))
        {
            Arguments chosen = new Arguments()
                .Add("encoding_parameters", "string", TextOf(encoding))
                .Add("transport_parameters", "string", TextOf(transport));
            return Client.Application.Strand.Run(() => Connect(chosen, token));
        }

        /// <summary>Ends a stream.</summary>
        /// <exception cref="UnsupportedException">there is no such stream</exception>
        public Task DisconnectStreamAsync(string streamId, CancellationToken token = default(CancellationToken))
        {
            return Act(Methods.StreamDisconnectStream, "disconnect_stream", streamId, token);
        }

        /// <summary>Suspends a stream; it stays connected, and no media arrive.</summary>
        /// <exception cref="UnsupportedException">there is no such stream</exception>
        public Task SuspendStreamAsync(string streamId, CancellationToken token = default(CancellationToken))
        {
            return Act(Methods.StreamSuspendStream, "suspend_stream", streamId, token);
        }

        /// <summary>Resumes a stream that was suspended.</summary>
        /// <exception cref="UnsupportedException">there is no such stream</exception>
        public Task ResumeStreamAsync(string streamId, CancellationToken token = default(CancellationToken))
        {
            return Act(Methods.StreamResumeStream, "resume_stream", streamId, token);
        }

        /// <summary>Returns the status of a stream (RoIS 2.0, table 8.10).</summary>
        /// <exception cref="UnsupportedException">there is no such stream</exception>
        public Task<StreamStatus> GetStreamStatusAsync(
            string streamId, CancellationToken token = default(CancellationToken))
        {
            return Client.Application.Strand.Run(() => GetStatus(streamId, token));
        }

        /// <summary>
        /// Reports how long media of a stream wait here until they are played: only the player knows that delay. Worth saying
        /// again when it has changed, every two seconds at most.
        /// </summary>
        /// <exception cref="UnsupportedException">there is no such stream, or the gateway does not have the extension</exception>
        public Task ReportPlayoutAsync(
            string streamId, TimeSpan delay, CancellationToken token = default(CancellationToken))
        {
            double milliseconds = Math.Min(Math.Max(delay.TotalMilliseconds, 0), LongestPlayout);
            var given = new ReportPlayoutParams { StreamId = streamId, Milliseconds = (int)Math.Round(milliseconds) };
            return Client.CallAsync(Methods.StreamReportPlayout, given, token);
        }

        /// <summary>
        /// States anew what may be done with all that this application sends to the engine, by purpose; none withdraws it.
        /// What it consents to before the first packet is said with the stream: <c>new { direction = "sendonly", consent =
        /// new[] { "live" } }</c>.
        /// </summary>
        /// <returns>the name that this application has as a visitor</returns>
        /// <exception cref="UnsupportedException">this application sends no such stream</exception>
        public Task<string> SetConsentAsync(
            string streamId, IEnumerable<Purpose> consent, CancellationToken token = default(CancellationToken))
        {
            var given = new SetConsentParams { StreamId = streamId, Consent = new List<Purpose>(consent) };
            return Client.Application.Strand.Run(async () =>
                (await Client.Application.Connection.ActAsync(Methods.StreamSetConsent, given, token)).VisitorRef);
        }

        private async Task<string> Connect(Arguments chosen, CancellationToken token)
        {
            if (IsExtended)
            {
                try
                {
                    return await ConnectExtended(chosen, token);
                }
                catch (UnsupportedException) when (chosen.List.Count == 0)
                {
                    // The engine behind the gateway may lack the extension.
                }
            }
            else if (chosen.List.Count > 0)
            {
                await new Step(Client, ComponentRef, "set_parameter", chosen).RunAsync(token);
            }
            Task<string> connecting = Command(
                "connect_stream", null, given => given.Value<string>("stream_id", "string")).RunAsync();
            try
            {
                return await connecting.OrCanceled(token);
            }
            catch (OperationCanceledException)
            {
                // The command goes on, and its stream would belong to an application that never learns its id.
                GiveBack(connecting).LetRun();
                throw;
            }
        }

        private async Task<string> ConnectExtended(Arguments chosen, CancellationToken token)
        {
            var given = new ConnectStreamParams { ComponentRef = ComponentRef };
            foreach (Argument each in chosen.List)
            {
                given.Parameters.Add(
                    new Parameter { Name = each.Name, DataTypeRef = each.DataTypeRef, Value = each.Value });
            }
            ConnectStreamResult result = await Client.Application.Connection.ActAsync(
                Methods.StreamConnectStream,
                given,
                token,
                null,
                late => Client.Application.Connection.Post(
                    Methods.StreamDisconnectStream, new StreamParams { StreamId = late.StreamId }));
            return result.StreamId;
        }

        private async Task GiveBack(Task<string> connecting)
        {
            await DisconnectStreamAsync(await connecting);
        }

        private Task Act(
            Method<StreamParams, ReturnResult> method, string verb, string streamId, CancellationToken token)
        {
            return Client.Application.Strand.Run(async () =>
            {
                if (IsExtended)
                {
                    try
                    {
                        var given = new StreamParams { StreamId = streamId };
                        await Client.Application.Connection.ActAsync(method, given, token);
                        return;
                    }
                    catch (UnsupportedException)
                    {
                        // So says an engine without the extension, too.
                    }
                }
                Step step = Command(verb, new Arguments().Add("stream_id", "string", streamId));
                await UnknownOtherwise(streamId, async () =>
                {
                    await step.RunAsync(token);
                    return true;
                });
            });
        }

        private async Task<StreamStatus> GetStatus(string streamId, CancellationToken token)
        {
            if (IsExtended)
            {
                try
                {
                    var given = new StreamParams { StreamId = streamId };
                    return (await Client.Application.Connection.ActAsync(
                        Methods.StreamQueryStreamStatus, given, token)).Status;
                }
                catch (UnsupportedException)
                {
                    // So says an engine without the extension, too.
                }
            }
            string condition = Condition.And(
                Condition.ComponentRef(ComponentRef), "stream_id = " + Condition.Quoted(streamId));
            return await UnknownOtherwise(streamId, () => QueryStatus(condition, token));
        }

        private async Task<StreamStatus> QueryStatus(string condition, CancellationToken token)
        {
            try
            {
                var values = await Client.QueryAsync("get_stream_status", condition, token);
                return Payload.Read("get_stream_status of " + ComponentRef, values, ReadStatus);
            }
            catch (BadParameterException)
            {
                // A query has no arguments, and not every gateway takes one in the condition.
            }
            return await QueryAsync("get_stream_status", ReadStatus, token);
        }

        /// <summary>Tries in strict RoIS what the extension does not know; where that fails too there is no such stream.</summary>
        private async Task<T> UnknownOtherwise<T>(string streamId, Func<Task<T>> work)
        {
            try
            {
                return await work();
            }
            catch (RoISException) when (IsExtended)
            {
                throw new UnsupportedException(ComponentRef + " has no stream " + streamId);
            }
        }

        private static StreamStatus ReadStatus(Payload told)
        {
            return told.Enumerator<StreamStatus>("status");
        }

        private static string TextOf(object parameters)
        {
            return parameters == null ? null : JObject.FromObject(parameters).ToString(Newtonsoft.Json.Formatting.None);
        }
    }

    /// <summary>A stream has another status.</summary>
    public sealed class StreamChange
    {
        internal StreamChange(string streamId, StreamStatus status, DateTimeOffset timestamp)
        {
            StreamId = streamId;
            Status = status;
            Timestamp = timestamp;
        }

        /// <summary>The stream; null where a component does not say it.</summary>
        public string StreamId { get; private set; }

        public StreamStatus Status { get; private set; }

        public DateTimeOffset Timestamp { get; private set; }
    }
}
