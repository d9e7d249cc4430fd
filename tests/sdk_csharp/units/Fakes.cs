// What tests of the SDK's parts have in common: a clock that stands, and sockets in memory.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using Newtonsoft.Json.Linq;
using OpenRoIS;

/// <summary>A clock that is set by hand.</summary>
public sealed class StandingClock : ITiming
{
    private readonly List<Alarm> _alarms = new List<Alarm>();

    public long Milliseconds { get; private set; }

    /// <summary>Whether what is disposed of rings nevertheless, as a timer does that rings in the same moment.</summary>
    public bool RingsLate { get; set; }

    public int Alarms
    {
        get
        {
            lock (_alarms)
            {
                return _alarms.Count;
            }
        }
    }

    public IDisposable After(long milliseconds, Action ring)
    {
        var alarm = new Alarm { At = Milliseconds + milliseconds, Ring = ring };
        lock (_alarms)
        {
            _alarms.Add(alarm);
        }
        alarm.Gone = () =>
        {
            lock (_alarms)
            {
                if (!RingsLate)
                {
                    _alarms.Remove(alarm);
                }
            }
        };
        return alarm;
    }

    public void Advance(long milliseconds)
    {
        List<Alarm> due;
        lock (_alarms)
        {
            Milliseconds += milliseconds;
            due = _alarms.Where(alarm => alarm.At <= Milliseconds).OrderBy(alarm => alarm.At).ToList();
            _alarms.RemoveAll(alarm => alarm.At <= Milliseconds);
        }
        foreach (Alarm alarm in due)
        {
            alarm.Ring();
        }
    }

    private sealed class Alarm : IDisposable
    {
        internal long At;
        internal Action Ring;
        internal Action Gone;

        public void Dispose()
        {
            Gone();
        }
    }
}

/// <summary>One end of a connection in memory.</summary>
public sealed class MemorySocket : IMessageSocket
{
    private readonly Feed<string> _incoming = new Feed<string>(4096);
    private MemorySocket _other;

    public int CloseCode { get; private set; } = 1006;

    public string CloseReason { get; private set; } = "";

    /// <summary>Whether what is sent waits for ever.</summary>
    public bool IsStuck { get; set; }

    /// <summary>Ends when a close has been sent.</summary>
    public Task CloseTakes { get; set; } = Task.FromResult(true);

    public bool IsDisposed { get; private set; }

    public static MemorySocket[] Pair()
    {
        var one = new MemorySocket();
        var other = new MemorySocket { _other = one };
        one._other = other;
        return new[] { one, other };
    }

    public Task SendAsync(string text)
    {
        if (IsStuck)
        {
            return new TaskCompletionSource<bool>().Task;
        }
        _other._incoming.Offer(text);
        return Task.FromResult(true);
    }

    public async Task<string> ReceiveAsync()
    {
        return await _incoming.MoveNextAsync() ? _incoming.Current : null;
    }

    public Task CloseAsync(int code, string reason)
    {
        End(code, reason);
        _other.End(code, reason);
        return CloseTakes;
    }

    /// <summary>Breaks the connection without a word.</summary>
    public void Break()
    {
        _incoming.End();
        _other._incoming.End();
    }

    public void Dispose()
    {
        IsDisposed = true;
        _incoming.End();
    }

    private void End(int code, string reason)
    {
        if (CloseCode == 1006)
        {
            CloseCode = code;
            CloseReason = reason;
        }
        _incoming.End();
    }
}

/// <summary>A gateway in memory that answers what it is told to.</summary>
public sealed class ScriptedGateway : ITransport
{
    private readonly Feed<JObject> _requests = new Feed<JObject>(4096);
    private readonly Queue<Exception> _refusals = new Queue<Exception>();

    public readonly List<string> Tokens = new List<string>();

    /// <summary>Requests that are answered here; the others are the test's.</summary>
    public readonly Dictionary<string, Func<JObject, JObject>> Answers = new Dictionary<string, Func<JObject, JObject>>
    {
        { "rois.system.connect", given => Ok() },
        { "rois.system.disconnect", given => Ok() },
        { "openrois.hello", given => Ok(new JProperty("extensions", new JArray("openrois.lease"))) },
        { "openrois.lease.resume", given => Ok(new JProperty("token", "u"), new JProperty("grace_ms", 10000)) },
        { "openrois.lease.token", given => Ok(new JProperty("token", "t"), new JProperty("grace_ms", 10000)) }
    };

    public MemorySocket Socket { get; private set; }

    /// <summary>The other end of it.</summary>
    public MemorySocket ClientSocket { get; private set; }

    /// <summary>Holds up what opens connections, which does not heed its token; null for not.</summary>
    public TaskCompletionSource<bool> Opening { get; set; }

    public int Opened { get; private set; }

    public static JObject Ok(params JProperty[] members)
    {
        var result = new JObject(new JProperty("return_code", "OK"));
        foreach (JProperty member in members)
        {
            result.Add(member);
        }
        return result;
    }

    public void Refuse(Exception error)
    {
        _refusals.Enqueue(error);
    }

    public async Task<IMessageSocket> OpenAsync(Uri address, string token, CancellationToken cancellation)
    {
        if (Opening != null)
        {
            await Opening.Task;
        }
        Tokens.Add(token);
        if (_refusals.Count > 0)
        {
            throw _refusals.Dequeue();
        }
        Opened++;
        MemorySocket[] pair = MemorySocket.Pair();
        ClientSocket = pair[0];
        Socket = pair[1];
        Serve(pair[1]);
        return pair[0];
    }

    /// <summary>The next request that is the test's.</summary>
    public async Task<JObject> RequestAsync(string method)
    {
        await _requests.MoveNextAsync();
        Check.Equal(method, (string)_requests.Current["method"]);
        return _requests.Current;
    }

    public void Answer(JObject request, JObject result)
    {
        Socket.SendAsync(new JObject(
            new JProperty("jsonrpc", "2.0"), new JProperty("id", request["id"]), new JProperty("result", result)).ToString());
    }

    public void Notify(string method, JObject given)
    {
        Socket.SendAsync(new JObject(
            new JProperty("jsonrpc", "2.0"), new JProperty("method", method), new JProperty("params", given)).ToString());
    }

    private async void Serve(MemorySocket socket)
    {
        for (string text = await socket.ReceiveAsync(); text != null; text = await socket.ReceiveAsync())
        {
            JObject request = JObject.Parse(text);
            Func<JObject, JObject> answer;
            if (Answers.TryGetValue((string)request["method"], out answer))
            {
                Answer(request, answer((JObject)request["params"]));
            }
            else
            {
                _requests.Offer(request);
            }
        }
    }
}
