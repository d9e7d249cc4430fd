// What a gateway, a program or a platform may do that it should not.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using Newtonsoft.Json.Linq;
using OpenRoIS;
using OpenRoIS.Media;

public static class MessageFaultTests
{
    private const int Times = 20000;

    private static readonly string[] Seeds =
    {
        "{\"jsonrpc\":\"2.0\",\"id\":1,\"error\":{\"code\":99999999999999999999,\"message\":\"x\"}}",
        "{\"jsonrpc\":\"2.0\",\"id\":1,\"error\":{\"code\":1,\"message\":\"x\",\"data\":[{\"path\":\"a\",\"message\":\"b\"}]}}",
        "{\"jsonrpc\":\"2.0\",\"method\":\"\\ud800\",\"params\":{\"a\":\"\\uZZZZ\"}}",
        "{\"jsonrpc\":\"2.0\",\"method\":\"m\",\"id\":0xFFFFFFFFFFFFFFFFFFFF}",
        "{\"jsonrpc\":\"2.0\",\"id\":1e999,\"result\":{\"a\":[1,null,{\"b\":new Date(5)}]}}"
    };

    public static void ATextThatIsNoMessageIsAViolationAndNoException()
    {
        const string marks = "{}[]\",:\\0123456789.eExX-+ntfu'/*\u0000\ud800aB ";
        var chance = new Random(7);
        for (int time = 0; time < Times; time++)
        {
            List<char> text = Seeds[time % Seeds.Length].ToList();
            for (int change = time < Seeds.Length ? 0 : chance.Next(1, 5); change > 0; change--)
            {
                int place = chance.Next(text.Count);
                if (chance.Next(2) == 0)
                {
                    text.RemoveAt(place);
                }
                text.Insert(place, marks[chance.Next(marks.Length)]);
            }
            JsonRpcMessage.Read(new string(text.ToArray()));
        }
        Check.Equal(JsonRpcKind.Violation, JsonRpcMessage.Read(Seeds[2]).Kind);
        Check.Equal("the answer's error object is malformed (-32600)", JsonRpcMessage.Read(Seeds[0]).Error.Message);
    }

    public static void AValueOfAnotherTypeSaysWhichItIs()
    {
        var values = new[] { new Result { Name = "number", DataTypeRef = "int", Value = "7" } };
        ComponentFailedException error = Check.Throws<ComponentFailedException>(
            () => Payload.Read("x", values, told => told.Value<int>("number", "int")));
        Check.Equal("x returned a value that does not fit: number is read as Int64, not as Int32", error.Message);
        Check.Throws<ComponentFailedException>(() => Payload.Read("x", values, told => told.List<string>("number", "int")));
        Check.Throws<ComponentFailedException>(
            () => Payload.Read("x", values, told => told.FindList<string>("number", "int")));
        Check.Equal(7L, Payload.Read("x", values, told => told.Value<long>("number", "int")));
    }
}

public static class SessionFaultTests
{
    public static async Task AHandlerThatFailsDoesNotEndTheSession()
    {
        MemorySocket[] sockets = MemorySocket.Pair();
        var failures = new List<string>();
        var heard = new TaskCompletionSource<string>();
        var session = new JsonRpcSession(sockets[0], new Strand(), new StandingClock())
        {
            FailureHandler = error => failures.Add(error.Message),
            NotificationHandler = (method, given) =>
            {
                if (method == "first")
                {
                    throw new FormatException("a mistake");
                }
                heard.TrySetResult(method);
            }
        };
        Task<Closing> running = session.RunAsync();
        await sockets[1].SendAsync("{\"jsonrpc\":\"2.0\",\"method\":\"first\"}");
        await sockets[1].SendAsync("{\"jsonrpc\":\"2.0\",\"method\":\"second\"}");
        Check.Equal("second", await heard.Task);
        Check.Equal(new[] { "a mistake" }, failures);
        sockets[1].Break();
        await running;
    }

    public static async Task ASocketThatFailsEndsItsSessionAndIsDisposedOf()
    {
        var socket = new FailingSocket();
        var failures = new List<string>();
        var session = new JsonRpcSession(socket, new Strand(), new StandingClock())
        {
            FailureHandler = error => failures.Add(error.Message)
        };
        Check.Equal(1006, (await session.RunAsync()).Code);
        Check.Equal(new[] { "a mistake of the transport" }, failures);
        Check.True(socket.IsDisposed, "it is disposed of");
    }

    private sealed class FailingSocket : IMessageSocket
    {
        internal bool IsDisposed { get; private set; }

        public int CloseCode
        {
            get { return 1006; }
        }

        public string CloseReason
        {
            get { return ""; }
        }

        public Task SendAsync(string text)
        {
            return Task.FromResult(true);
        }

        public async Task<string> ReceiveAsync()
        {
            await Task.Yield();
            throw new FormatException("a mistake of the transport");
        }

        public Task CloseAsync(int code, string reason)
        {
            return Task.FromResult(true);
        }

        public void Dispose()
        {
            IsDisposed = true;
        }
    }
}

public static class ConnectionFaultTests
{
    public static async Task AClientThatIsClosedMakesNoOtherConnection()
    {
        var place = new Place();
        await place.Client.ConnectAsync();
        var farewell = new TaskCompletionSource<bool>();
        place.Gateway.ClientSocket.CloseTakes = farewell.Task;
        Task closing = place.Client.CloseAsync();
        await place.Settle();
        // The connection is over; the socket is still taking leave.
        place.Clock.Advance(600);
        await place.Settle();
        Check.Equal(1, place.Gateway.Opened);
        farewell.TrySetResult(true);
        await closing;
        Check.Equal(new[] { "Connecting", "Connected", "Closed" }, await place.StatesUntilClosed());
    }

    public static async Task ATransportThatDoesNotHeedItsTokenIsGivenUp()
    {
        var place = new Place();
        place.Gateway.Opening = new TaskCompletionSource<bool>();
        Task connecting = place.Client.ConnectAsync();
        await place.Settle();
        place.Clock.Advance(10000);
        ConnectionFailedException error = await Check.ThrowsAsync<ConnectionFailedException>(() => connecting);
        Check.Equal("the gateway did not answer within 10000 ms", error.Message);
        // What it opens now serves nothing.
        place.Gateway.Opening.TrySetResult(true);
        await place.Settle();
        Check.True(place.Gateway.ClientSocket.IsDisposed, "it is disposed of");
    }

    public static async Task AClockThatRingsInTheMomentOfTheConnectionEndsNothing()
    {
        var place = new Place();
        place.Clock.RingsLate = true;
        await place.Client.ConnectAsync();
        // An exception on a thread of the pool would end the program.
        place.Clock.Advance(10000);
        await place.Settle();
        Check.Equal(ConnectionState.Connected, place.Client.State);
        await place.Client.CloseAsync();
    }

    public static async Task AClientThatIsClosedWhileItConnectsIsClosed()
    {
        var place = new Place();
        place.Gateway.Answers.Remove("rois.system.connect");
        Task connecting = place.Client.ConnectAsync();
        await place.Gateway.RequestAsync("rois.system.connect");
        place.Client.Dispose();
        await Check.ThrowsAsync<OperationCanceledException>(() => connecting);
        await place.Client.CloseAsync();
        Check.Equal(ConnectionState.Closed, place.Client.State);
        Check.Equal(0, place.Clock.Alarms);
        ConnectionLostException over = await Check.ThrowsAsync<ConnectionLostException>(() => place.Client.SearchAsync());
        Check.Equal("rois.command.search: the client is closed", over.Message);
    }

    public static async Task AnAnswerThatCannotBeReadIsOneCallersError()
    {
        var place = new Place();
        await place.Client.ConnectAsync();
        foreach (string answer in new[]
        {
            "null", "7", "[]", "{}", "{\"return_code\":\"NEW\"}", "{\"return_code\":\"OK\"}", "{\"return_code\":null}",
            "{\"return_code\":\"OK\",\"component_ref_list\":[null]}", "{\"return_code\":\"OK\",\"component_ref_list\":{}}"
        })
        {
            Task<IReadOnlyList<string>> searching = place.Client.SearchAsync();
            JObject request = await place.Gateway.RequestAsync("rois.command.search");
            await place.Gateway.Socket.SendAsync("{\"jsonrpc\":\"2.0\",\"id\":" + request["id"] + ",\"result\":" + answer + "}");
            if (answer == "{\"return_code\":\"OK\"}")
            {
                Check.Equal(0, (await searching).Count);
                continue;
            }
            RpcException error = await Check.ThrowsAsync<RpcException>(() => searching);
            Check.True(error.Message.Contains("the answer to rois.command.search cannot be read"), error.Message);
        }
        Check.Equal(ConnectionState.Connected, place.Client.State);
        await place.Client.CloseAsync();
    }

    public static async Task AHandlerOfFailuresThatFailsHoldsNothingUp()
    {
        var heard = new TaskCompletionSource<bool>();
        var place = new Place(new ClientOptions
        {
            Callbacks = new Strand(null, error => { throw error; }),
            HandlerFailed = error => { throw new FormatException("a handler of failures fails"); }
        });
        place.Client.ProfileChanged += _ => { throw new FormatException("a handler fails"); };
        place.Client.Fault += told => heard.TrySetResult(true);
        await place.Client.ConnectAsync();
        place.Gateway.Notify("rois.system.profile_changed", new JObject());
        place.Gateway.Notify("rois.system.notify_error", new JObject(
            new JProperty("error_id", "e"), new JProperty("error_type", "ENGINE_INTERNAL_ERROR"), new JProperty("expire", "")));
        await heard.Task;
        await place.Client.CloseAsync();
    }

    public static void OptionsThatCannotBeAreRefused()
    {
        var wrong = new Dictionary<string, ClientOptions>
        {
            { "ConnectTimeout", new ClientOptions { ConnectTimeout = TimeSpan.Zero } },
            { "RequestTimeout", new ClientOptions { RequestTimeout = TimeSpan.MaxValue } },
            { "IdleProbe", new ClientOptions { IdleProbe = Timeout.InfiniteTimeSpan } },
            { "Transport", new ClientOptions { Transport = null } },
            { "Timing", new ClientOptions { Timing = null } },
            { "HandlerFailed", new ClientOptions { HandlerFailed = null } },
            { "Reconnect", new ClientOptions { Reconnect = null } },
            { "Reconnect.First", new ClientOptions { Reconnect = new Reconnect { First = TimeSpan.Zero } } },
            { "Reconnect.Factor", new ClientOptions { Reconnect = new Reconnect { Factor = 0.5 } } },
            { "Reconnect.Limit", new ClientOptions { Reconnect = new Reconnect { Limit = TimeSpan.FromDays(2) } } }
        };
        foreach (KeyValuePair<string, ClientOptions> each in wrong)
        {
            ArgumentException error = Check.Throws<ArgumentException>(() => new Client("ws://gateway/", each.Value));
            Check.True(error.Message.StartsWith("ClientOptions." + each.Key + " "), error.Message);
        }
    }

    public static void OptionsThatTwoClientsShareStayWhatTheyWere()
    {
        var options = new ClientOptions();
        var one = new Client("ws://gateway/", options);
        var other = new Client("ws://gateway/", options);
        Check.True(options.Callbacks == null, "nothing is written into them");
        Check.True(one.CallbackContext != other.CallbackContext, "each has its own context");
    }
}

public static class CallbackFaultTests
{
    public static void APumpInACallbackRunsTheRest()
    {
        var dispatcher = new Dispatcher(error => { throw error; });
        var done = new List<int>();
        dispatcher.Post(_ => done.Add(dispatcher.Pump()), null);
        dispatcher.Post(_ => done.Add(0), null);
        dispatcher.Pump();
        Check.Equal(new[] { 0, 1 }, done);
    }

    public static async Task AContextThatTakesNothingEndsNothing()
    {
        var failures = new List<string>();
        var place = new Place(new ClientOptions
        {
            Callbacks = new ClosedContext(),
            HandlerFailed = error => failures.Add(error.Message)
        });
        await place.Client.ConnectAsync();
        place.Gateway.Socket.Break();
        await place.Settle();
        place.Clock.Advance(1000);
        await place.Settle();
        Check.Equal(ConnectionState.Connected, place.Client.State);
        Check.True(failures.All(each => each == "it is closed") && failures.Count > 0, string.Join(", ", failures));
        await place.Client.CloseAsync();
    }

    public static async Task AStrandWhoseHandlerOfFailuresFailsGoesOn()
    {
        var strand = new Strand(null, error => { throw new FormatException("once more"); });
        strand.Post(() => { throw new FormatException("once"); });
        Check.Equal(1, await strand.Run(() => Task.FromResult(1)));
    }

    public static async Task AnEventThatItsAuthorCannotReadIsCountedAndTold()
    {
        var failures = new TaskCompletionSource<string>();
        var place = new Place(new ClientOptions { HandlerFailed = error => failures.TrySetResult(error.Message) });
        await place.Client.ConnectAsync();
        var lamp = new ComponentEvent<string>(
            place.Client, "switched", "robot/lamp",
            told => { throw new InvalidCastException("a mistake of the author"); });
        Task<EventReader<string>> opening = lamp.ReadAsync();
        JObject request = await place.Gateway.RequestAsync("rois.event.subscribe");
        place.Gateway.Answer(request, ScriptedGateway.Ok(new JProperty("subscribe_id", "s")));
        EventReader<string> reader = await opening;
        place.Gateway.Notify("rois.event.notify_event", new JObject(
            new JProperty("event_id", "e"), new JProperty("event_type", "switched"), new JProperty("subscribe_id", "s"),
            new JProperty("expire", ""),
            new JProperty("results", new JArray(new JObject(
                new JProperty("name", "on"), new JProperty("data_type_ref", "bool"), new JProperty("value", "true"))))));
        Check.Equal("a mistake of the author", await failures.Task);
        Check.Equal(1, reader.Unreadable);
        Check.Equal(ConnectionState.Connected, place.Client.State);
        await place.Client.CloseAsync();
    }
}

public sealed class ClosedContext : SynchronizationContext
{
    public override void Post(SendOrPostCallback work, object state)
    {
        throw new InvalidOperationException("it is closed");
    }
}

public static class MediaSessionTests
{
    private const string Offer = "{\"peer_id\":\"p\",\"generation\":1,\"sdp\":\"v=0\",\"streams\":[]}";

    public static async Task PeersAreDisposedOfWithTheirSessionAlsoWhereNothingIsPumpedAnyMore()
    {
        var dispatcher = new Dispatcher(error => { throw error; });
        var place = new Place(new ClientOptions { Callbacks = dispatcher });
        await place.Client.ConnectAsync();
        var said = new List<string>();
        var media = new MediaSession(place.Client, request => new Peer(said));
        place.Gateway.Answers["signaling.ice_servers"] = given => ScriptedGateway.Ok();
        place.Gateway.Notify("signaling.offer", JObject.Parse(Offer));
        while (said.Count < 2)
        {
            await place.Settle();
            dispatcher.Pump();
        }
        media.Dispose();
        Check.Equal(new[] { "open", "answer", "dispose" }, said);
        await place.Settle();
        media.Dispose();
        dispatcher.Pump();
        Check.Equal(3, said.Count);
        await place.Client.CloseAsync();
    }

    public static async Task CandidatesThatFloodASleepingProgramAreBounded()
    {
        var dispatcher = new Dispatcher(error => { throw error; });
        var place = new Place(new ClientOptions { Callbacks = dispatcher });
        await place.Client.ConnectAsync();
        var said = new List<string>();
        using (new MediaSession(place.Client, request => new Peer(said)))
        {
            place.Gateway.Answers["signaling.ice_servers"] = given => ScriptedGateway.Ok();
            place.Gateway.Answers["signaling.answer"] = given => ScriptedGateway.Ok();
            place.Gateway.Notify("signaling.offer", JObject.Parse(Offer));
            while (said.Count < 2)
            {
                await place.Settle();
                dispatcher.Pump();
            }
            await place.Settle();
            for (int number = 0; number < 1000; number++)
            {
                place.Gateway.Notify("signaling.candidate", JObject.Parse(
                    "{\"peer_id\":\"p\",\"generation\":1,\"candidate\":\"c\",\"sdp_mid\":\"0\",\"sdp_m_line_index\":0}"));
                await place.Settle(1);
            }
            await place.Settle();
            Check.True(dispatcher.Waiting < 200, dispatcher.Waiting + " wait");
            dispatcher.Pump();
            Check.True(said.Contains("candidate"), "those that have room are added");
        }
        await place.Client.CloseAsync();
    }

    private sealed class Peer : IMediaPeer
    {
        private readonly List<string> _said;

        internal Peer(List<string> said)
        {
            _said = said;
            _said.Add("open");
        }

        public Task<string> AnswerAsync(Offer offer)
        {
            _said.Add("answer");
            return Task.FromResult("v=0");
        }

        public void AddCandidate(Candidate candidate)
        {
            _said.Add("candidate");
        }

        public void Dispose()
        {
            _said.Add("dispose");
        }
    }
}
