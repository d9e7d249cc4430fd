// Applications at gateways that do what they should not.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.IO;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using Newtonsoft.Json.Linq;
using OpenRoIS;
using OpenRoIS.Components;

/// <summary>Tries to connect to each of several addresses, and says what came of it.</summary>
public static class Barred
{
    public static async Task Run(string urls)
    {
        Program.Say("failed", await Task.WhenAll(urls.Split(' ').Select(Failure)));
    }

    private static async Task<string> Failure(string url)
    {
        using (var client = new Client(url, new ClientOptions { ConnectTimeout = TimeSpan.FromSeconds(3) }))
        {
            try
            {
                await client.ConnectAsync();
                return "";
            }
            catch (ConnectionFailedException error)
            {
                return error.Message;
            }
        }
    }
}

/// <summary>Listens to a lamp at a gateway that says anything.</summary>
public static class Steadfast
{
    public static async Task Run(string url)
    {
        var failures = new List<string>();
        var options = new ClientOptions { HandlerFailed = error => failures.Add(error.Message) };
        Client client = await Program.Connect(url, options);
        client.ConnectionChanged += change =>
        {
            if (change.State == ConnectionState.Waiting)
            {
                Program.Say("lost", change.Reason);
            }
        };
        client.SubscriptionRestored += change => Program.Say("restored", null);
        var lamp = new Lamp(client, "robot/lamp");
        Subscription subscription = await lamp.Switched.SubscribeAsync(on => Program.Say("switched", on));
        Program.Say("ready", null);
        await Program.Told();
        using (var soon = new CancellationTokenSource())
        {
            Task<IReadOnlyList<string>> given = client.SearchAsync("gives up", soon.Token);
            await Program.Told();
            soon.Cancel();
            Program.Say("gave up", await Program.Thrown(() => given));
        }
        Program.Say("found", await client.SearchAsync("twice"));
        Program.Say("again", await client.SearchAsync("once"));
        Program.Say("unreadable", subscription.Unreadable);
        Program.Say("failures", failures);
        await client.CloseAsync();
    }

    private sealed class Lamp : ComponentProxy
    {
        internal Lamp(Client client, string componentRef)
            : base(client, componentRef)
        {
        }

        internal ComponentEvent<bool> Switched
        {
            get { return Event("switched", told => told.Value<bool>("on", "bool")); }
        }
    }
}

/// <summary>Comes back often, beside another client, and leaves nothing behind.</summary>
public static class Frugal
{
    public static async Task Run(string url)
    {
        int times = int.Parse(Environment.GetEnvironmentVariable("TIMES"));
        Client other = await Program.Connect(url);
        await Round(url);
        int files = Files();
        int threads = Process.GetCurrentProcess().Threads.Count;
        for (int time = 0; time < times; time++)
        {
            await Round(url);
        }
        // The other client was not touched by any of these.
        Program.Say("other", (await other.SearchAsync()).Count > 0);
        Program.Say("files", Files() - files);
        Program.Say("threads", Process.GetCurrentProcess().Threads.Count - threads);
        await other.CloseAsync();
    }

    /// <summary>Connects, and is closed in a handler of its own.</summary>
    private static async Task Round(string url)
    {
        var over = new TaskCompletionSource<bool>();
        var client = new Client(url);
        client.ConnectionChanged += change =>
        {
            if (change.State == ConnectionState.Connected)
            {
                client.Dispose();
            }
            else if (change.State == ConnectionState.Closed)
            {
                over.TrySetResult(true);
            }
        };
        await client.ConnectAsync();
        await over.Task;
        await client.CloseAsync();
    }

    private static int Files()
    {
        return Directory.GetFiles("/proc/self/fd").Length;
    }
}

/// <summary>
/// Uses a gateway in many ways at once, and gives up at any moment, while its connection is cut: each call ends, and nothing
/// of it stays.
/// </summary>
public static class Restless
{
    private const int Tasks = 12;

    /// <summary>Calls that end between two words of it.</summary>
    private const int Many = 20;

    private static readonly Dictionary<string, int> Ends = new Dictionary<string, int>();

    public static async Task Run(string url)
    {
        var failures = new List<string>();
        var options = new ClientOptions { HandlerFailed = error => failures.Add(error.ToString()) };
        Client client = await Program.Connect(url, options);
        var over = new CancellationTokenSource();
        int seed = int.Parse(Environment.GetEnvironmentVariable("SEED"));
        Task[] working = Enumerable.Range(0, Tasks).Select(each => Work(client, new Random(seed + each), over.Token)).ToArray();
        Program.Say("ready", null);
        await Program.Told();
        over.Cancel();
        await Task.WhenAll(working);
        // What was asked last is there.
        await client.SearchAsync();
        Program.Say("free", (await client.BodiesAsync()).Select(body => body.IsFree));
        Program.Say("ended", Ends.Keys.OrderBy(each => each));
        Program.Say("failures", failures);
        await client.CloseAsync();
    }

    private static async Task Work(Client client, Random chance, CancellationToken over)
    {
        while (!over.IsCancellationRequested)
        {
            using (CancellationTokenSource soon = CancellationTokenSource.CreateLinkedTokenSource(over))
            {
                if (chance.Next(2) == 0)
                {
                    soon.CancelAfter(chance.Next(20));
                }
                string end = await Program.Thrown(() => Once(client, chance, soon.Token));
                lock (Ends)
                {
                    int before;
                    Ends.TryGetValue(end, out before);
                    Ends[end] = before + 1;
                    if (Ends.Values.Sum() % Many == 0)
                    {
                        Program.Say("many", null);
                    }
                }
            }
        }
    }

    private static async Task Once(Client client, Random chance, CancellationToken token)
    {
        Navigation navigation = client.Component(Navigation.Type, "robot/navigation");
        switch (chance.Next(4))
        {
            case 0:
                await client.SearchAsync("", token);
                break;
            case 1:
                using (EventReader<ReachedTarget> reached = await navigation.ReachedTarget.ReadAsync(token))
                {
                    await navigation.ComponentStatusAsync(token);
                }
                break;
            case 2:
                using (Body body = await client.BodyAsync(new BodyRequest(Navigation.Type, Reaction.Type), token))
                {
                    await body.Part(Navigation.Type).StartAsync(token);
                }
                break;
            default:
                using (await client.BodyAsync(new BodyRequest(SpeechSynthesis.Type), token))
                {
                    await client.GetProfileAsync("", token);
                }
                break;
        }
    }
}
