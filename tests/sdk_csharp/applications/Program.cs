// Applications of the SDK, which sees nothing but its public side: each says what it saw as lines of JSON, and waits for a
// line of input where the test has to do something first.
using System;
using System.Collections.Generic;
using System.IO;
using System.Text;
using System.Threading;
using System.Threading.Tasks;
using Newtonsoft.Json;
using Newtonsoft.Json.Linq;
using OpenRoIS;

public static class Program
{
    private static readonly Dictionary<string, Func<string, Task>> All = new Dictionary<string, Func<string, Task>>
    {
        { "tour", Tour.Run },
        { "errors", Errors.Run },
        { "keeper", Keeper.Run },
        { "survivor", Survivor.Run },
        { "resumer", Resumer.Run },
        { "bearer", Bearer.Run },
        { "impatient", Impatient.Run },
        { "rivals", Rivals.Run },
        { "owner", Owner.Run },
        { "main_thread", MainThread.Run },
        { "one_thread", OneThread.Run },
        { "leaser", Leaser.Run },
        { "sharer", Sharer.Run },
        { "streamer", Streamer.Run },
        { "viewer", Viewer.Run },
        { "visiting", Visiting.Run },
        { "barred", Barred.Run },
        { "steadfast", Steadfast.Run },
        { "frugal", Frugal.Run },
        { "restless", Restless.Run }
    };

    private static readonly TextWriter Output =
        new StreamWriter(Console.OpenStandardOutput(), new UTF8Encoding(false)) { AutoFlush = true };

    public static int Main(string[] arguments)
    {
        try
        {
            All[arguments[0]](arguments[1]).GetAwaiter().GetResult();
            return 0;
        }
        catch (Exception error)
        {
            Console.Error.WriteLine(error);
            return 1;
        }
    }

    public static Task<Client> Connect(string url)
    {
        return Connect(url, new ClientOptions());
    }

    /// <summary>Connects, and comes back at once when that is cut off.</summary>
    public static async Task<Client> Connect(string url, ClientOptions options)
    {
        options.Reconnect = new Reconnect
        {
            First = TimeSpan.FromMilliseconds(20),
            Limit = TimeSpan.FromMilliseconds(50)
        };
        var client = new Client(url, options);
        await client.ConnectAsync();
        return client;
    }

    public static void Say(string about, object what)
    {
        lock (Output)
        {
            var line = new JObject(new JProperty(about, what == null ? null : JToken.FromObject(what)));
            Output.WriteLine(line.ToString(Formatting.None));
        }
    }

    public static Task Told()
    {
        return Task.Run(() => Console.In.ReadLine());
    }

    /// <summary>What some work throws: the type, and what it says of it.</summary>
    public static async Task<string> Thrown(Func<Task> work)
    {
        try
        {
            await work();
        }
        catch (Exception error)
        {
            return error.GetType().Name;
        }
        return "nothing";
    }

    public static Task<T> First<T>(Action<Action<T>> subscribe)
    {
        var first = new TaskCompletionSource<T>();
        subscribe(value => first.TrySetResult(value));
        return first.Task;
    }
}
