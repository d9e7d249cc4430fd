using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using Newtonsoft.Json.Linq;
using OpenRoIS;

public static class JsonRpcMessageTests
{
    public static void WhatIsNoMessageIsAViolationWithItsCode()
    {
        var wrong = new Dictionary<string, int>
        {
            { "", -32700 },
            { "{", -32700 },
            { "{}{}", -32700 },
            { new string('[', 200) + new string(']', 200), -32700 },
            { "[]", -32600 },
            { "null", -32600 },
            { "7", -32600 },
            { "{}", -32600 },
            { "{\"jsonrpc\":\"1.0\",\"method\":\"m\"}", -32600 },
            { "{\"jsonrpc\":\"2.0\",\"method\":7,\"id\":1}", -32600 },
            { "{\"jsonrpc\":\"2.0\",\"method\":\"m\",\"id\":true}", -32600 },
            { "{\"jsonrpc\":\"2.0\",\"method\":\"m\",\"id\":{}}", -32600 },
            { "{\"jsonrpc\":\"2.0\",\"method\":\"m\",\"id\":1,\"params\":[]}", -32602 },
            { "{\"jsonrpc\":\"2.0\",\"method\":\"m\",\"params\":[]}", 0 },
            { "{\"jsonrpc\":\"2.0\",\"id\":1}", -32600 }
        };
        foreach (KeyValuePair<string, int> each in wrong)
        {
            JsonRpcMessage message = JsonRpcMessage.Read(each.Key);
            Check.Equal(JsonRpcKind.Violation, message.Kind);
            Check.Equal(each.Value, message.WrongCode);
            Check.True(message.Wrong != "", "it says why");
        }
    }

    public static void MessagesAreReadAsWhatTheyAre()
    {
        JsonRpcMessage request = JsonRpcMessage.Read("{\"jsonrpc\":\"2.0\",\"method\":\"m\",\"id\":\"a\",\"params\":{\"x\":1}}");
        Check.Equal(JsonRpcKind.Request, request.Kind);
        Check.Equal("a", (string)request.Id);
        Check.Equal(1, (int)request.Params["x"]);
        Check.Equal(JsonRpcKind.Request, JsonRpcMessage.Read("{\"jsonrpc\":\"2.0\",\"method\":\"m\",\"id\":null}").Kind);
        Check.Equal(
            JsonRpcKind.Notification, JsonRpcMessage.Read("{\"jsonrpc\":\"2.0\",\"method\":\"m\",\"params\":null}").Kind);
        JsonRpcMessage response = JsonRpcMessage.Read("{\"jsonrpc\":\"2.0\",\"id\":1,\"result\":\"2026-06-01T12:00:00+02:00\"}");
        Check.Equal(JsonRpcKind.Response, response.Kind);
        // Newtonsoft would make a date of this, and another text of that.
        Check.Equal("2026-06-01T12:00:00+02:00", (string)response.Result);
        JsonRpcMessage error = JsonRpcMessage.Read(
            "{\"jsonrpc\":\"2.0\",\"id\":1,\"error\":{\"code\":-32602,\"message\":\"no\",\"data\":[{\"path\":\"a.b\",\"message\":\"c\"}]}}");
        Check.Equal(JsonRpcKind.Error, error.Kind);
        Check.Equal("no (-32602): a.b: c", error.Error.Message);
        Check.Equal(-32600L, JsonRpcMessage.Read("{\"jsonrpc\":\"2.0\",\"id\":1,\"error\":7}").Error.Code);
    }
}

public static class JsonRpcSessionTests
{
    private const long Within = 1000;

    public static async Task BothSidesAskAndNotify()
    {
        var line = new Line();
        var heard = new TaskCompletionSource<string>();
        line.Other.RequestHandler = async (method, given) =>
        {
            await Task.Yield();
            return new JObject(new JProperty("asked", method), new JProperty("with", given["x"]));
        };
        line.Other.NotificationHandler = (method, given) => heard.TrySetResult(method + given["y"]);
        line.One.RequestHandler = (method, given) => Task.FromResult<JToken>(new JValue("mine"));
        Check.Equal("{\"asked\":\"m\",\"with\":7}", await line.Ask(line.One, "m", new JObject(new JProperty("x", 7))));
        Check.Equal("\"mine\"", await line.Ask(line.Other, "n", new JObject()));
        line.In(() => line.One.Notify("told", new JObject(new JProperty("y", 8))));
        Check.Equal("told8", await heard.Task);
    }

    public static async Task ARequestThatIsRefusedSaysHow()
    {
        var line = new Line();
        RpcException unknown = await Check.ThrowsAsync<RpcException>(() => line.Ask(line.One, "m", new JObject()));
        Check.Equal(-32601L, unknown.Code);
        line.Other.RequestHandler = (method, given) =>
        {
            if (method == "mine")
            {
                throw new RpcException(-32000, "not today");
            }
            throw new FormatException("a secret of this side");
        };
        RpcException own = await Check.ThrowsAsync<RpcException>(() => line.Ask(line.One, "mine", new JObject()));
        Check.True(own.Message.Contains("not today"), own.Message);
        RpcException failed = await Check.ThrowsAsync<RpcException>(() => line.Ask(line.One, "fail", new JObject()));
        Check.Equal(-32603L, failed.Code);
        Check.True(!failed.Message.Contains("secret"), failed.Message);
    }

    public static async Task WhatIsNoMessageIsAnsweredAndTheSessionGoesOn()
    {
        var line = new Line();
        var wrong = new TaskCompletionSource<string>();
        line.One.ViolationHandler = said => wrong.TrySetResult(said);
        line.One.RequestHandler = (method, given) => Task.FromResult<JToken>(new JValue(1));
        await line.Sockets[1].SendAsync("no JSON");
        Check.Equal("the message is not JSON", await wrong.Task);
        Check.Equal("1", await line.Ask(line.Other, "m", new JObject()));
        // An answer that nothing waits for is passed over.
        await line.Sockets[1].SendAsync("{\"jsonrpc\":\"2.0\",\"id\":12345678901234567890123,\"result\":1}");
        Check.Equal("1", await line.Ask(line.Other, "m", new JObject()));
    }

    public static async Task AnAnswerThatIsLateIsTakenByWhatUndoesIt()
    {
        var line = new Line();
        var answer = new TaskCompletionSource<JToken>();
        var late = new TaskCompletionSource<string>();
        line.Other.RequestHandler = (method, given) => answer.Task;
        Task<string> asking = line.Ask(line.One, "m", new JObject(), raw => late.TrySetResult((string)raw));
        await line.Settle();
        line.Clock.Advance(Within - 1);
        // The connection lives: it is the answer alone that is late.
        line.In(() => line.Other.Notify("sign of life", new JObject()));
        await line.Settle();
        line.Clock.Advance(1);
        TimeoutException error = await Check.ThrowsAsync<TimeoutException>(() => asking);
        Check.Equal("m: no answer within 1000 ms", error.Message);
        answer.TrySetResult(new JValue("done nevertheless"));
        Check.Equal("done nevertheless", await late.Task);
        Check.Equal(0, line.Clock.Alarms);
    }

    public static async Task ATokenEndsTheWaitAndWhatComesThenIsUndone()
    {
        var line = new Line();
        var answer = new TaskCompletionSource<JToken>();
        var late = new TaskCompletionSource<string>();
        line.Other.RequestHandler = (method, given) => answer.Task;
        using (var soon = new CancellationTokenSource())
        {
            Task<string> asking = line.Ask(
                line.One, "m", new JObject(), raw => late.TrySetResult((string)raw), soon.Token);
            await line.Settle();
            soon.Cancel();
            await Check.ThrowsAsync<OperationCanceledException>(() => asking);
            answer.TrySetResult(new JValue("done"));
            Check.Equal("done", await late.Task);
            await Check.ThrowsAsync<OperationCanceledException>(
                () => line.Ask(line.One, "m", new JObject(), null, soon.Token));
        }
    }

    public static async Task AConnectionThatIsSilentIsGivenUp()
    {
        var line = new Line();
        line.Other.RequestHandler = (method, given) => new TaskCompletionSource<JToken>().Task;
        Task<string> asking = line.Ask(line.One, "m", new JObject());
        await line.Settle();
        line.Clock.Advance(Within);
        await Check.ThrowsAsync<TimeoutException>(() => asking);
        Closing closing = await line.Running;
        Check.Equal(4000, closing.Code);
        Check.Equal("no answer (4000)", closing.ToString());
    }

    public static async Task WhatWaitsFailsWhenTheConnectionBreaks()
    {
        var line = new Line();
        line.Other.RequestHandler = (method, given) => new TaskCompletionSource<JToken>().Task;
        Task<string> asking = line.Ask(line.One, "m", new JObject());
        await line.Settle();
        line.Sockets[0].Break();
        await Check.ThrowsAsync<ConnectionLostException>(() => asking);
        Check.Equal("closed (1006)", (await line.Running).ToString());
        await Check.ThrowsAsync<ConnectionLostException>(() => line.Ask(line.One, "m", new JObject()));
        line.In(() => line.One.Post("m", new JObject()));
        await line.Settle();
    }

    public static async Task TooManyUnansweredRequestsAreRefused()
    {
        var line = new Line(false);
        Task<string>[] asking = Enumerable.Range(0, JsonRpcSession.MostOutstanding)
            .Select(number => line.Ask(line.One, "m", new JObject())).ToArray();
        TimeoutException error = await Check.ThrowsAsync<TimeoutException>(() => line.Ask(line.One, "m", new JObject()));
        Check.True(error.Message.Contains("256 requests are unanswered"), error.Message);
        Check.True(asking.All(each => !each.IsCompleted), "the others wait");
    }

    public static async Task TooManyRequestsOfTheOtherSideAreAnsweredSo()
    {
        var line = new Line();
        var answer = new TaskCompletionSource<JToken>();
        line.Other.RequestHandler = (method, given) => answer.Task;
        Task<string>[] asking = Enumerable.Range(0, JsonRpcSession.MostServed)
            .Select(number => line.Ask(line.One, "m", new JObject())).ToArray();
        RpcException busy = await Check.ThrowsAsync<RpcException>(() => line.Ask(line.One, "m", new JObject()));
        Check.Equal(-32000L, busy.Code);
        answer.TrySetResult(new JValue(1));
        await Task.WhenAll(asking);
        Check.Equal("1", await line.Ask(line.One, "m", new JObject()));
    }

    public static async Task ASideThatDoesNotReadIsLeft()
    {
        var line = new Line();
        line.Sockets[0].IsStuck = true;
        for (int number = 0; number <= JsonRpcSession.MostQueued + 1; number++)
        {
            line.In(() => line.One.Notify("m", new JObject()));
        }
        Check.Equal("the other side does not read (4000)", (await line.Running).ToString());
    }

    /// <summary>Two sessions that are connected, in one strand.</summary>
    private sealed class Line
    {
        internal readonly StandingClock Clock = new StandingClock();
        internal readonly MemorySocket[] Sockets = MemorySocket.Pair();
        internal readonly JsonRpcSession One;
        internal readonly JsonRpcSession Other;
        internal readonly Task<Closing> Running;

        private readonly Strand _strand = new Strand();

        internal Line(bool answers = true)
        {
            One = new JsonRpcSession(Sockets[0], _strand, Clock);
            Other = new JsonRpcSession(Sockets[1], _strand, Clock);
            Running = _strand.Run(() => One.RunAsync());
            if (answers)
            {
                _strand.Run(() => Other.RunAsync());
            }
        }

        internal void In(Action work)
        {
            _strand.Post(work);
        }

        /// <summary>Waits until what was sent has arrived: it goes to and fro by way of the strand.</summary>
        internal async Task Settle()
        {
            for (int turn = 0; turn < 50; turn++)
            {
                await _strand.Run(() => Task.FromResult(true));
                await Task.Yield();
            }
        }

        internal Task<string> Ask(
            JsonRpcSession session,
            string method,
            JObject given,
            Action<JToken> late = null,
            CancellationToken token = default(CancellationToken))
        {
            return _strand.Run(async () =>
            {
                string answer = null;
                await session.RequestAsync(
                    method,
                    given,
                    Within,
                    token,
                    (raw, reason) => answer = raw.ToString(Newtonsoft.Json.Formatting.None),
                    late);
                return answer;
            });
        }
    }
}
