// Applications with a main thread, as a game has one.
using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using OpenRoIS;
using OpenRoIS.Components;

/// <summary>Gets every callback on the thread that pumps.</summary>
public static class MainThread
{
    public static Task Run(string url)
    {
        int main = Thread.CurrentThread.ManagedThreadId;
        var failures = new List<string>();
        var dispatcher = new Dispatcher(error => failures.Add(error.Message));
        var options = new ClientOptions { Callbacks = dispatcher, HandlerFailed = error => failures.Add(error.Message) };
        var reached = new List<string>();
        var threads = new HashSet<int>();
        var client = new Client(url, options);
        client.ConnectionChanged += change => threads.Add(Thread.CurrentThread.ManagedThreadId);
        // Nothing of this thread is needed to connect, to bind and to drive.
        client.ConnectAsync().Wait();
        Navigation navigation = client.Component(Navigation.Type, "robot/navigation");
        navigation.BindAsync().Wait();
        navigation.SetAsync(targetPositions: Enumerable.Range(0, 200).Select(each => "place " + each)).Wait();
        Subscription subscription = navigation.ReachedTarget.SubscribeAsync(told =>
        {
            threads.Add(Thread.CurrentThread.ManagedThreadId);
            reached.Add(told.Target);
            if (told.Target == "place 199")
            {
                throw new InvalidOperationException("a mistake of the application");
            }
        }).Result;
        navigation.StartAsync().Wait();
        navigation.StartAsync().Wait();
        Program.Say("before", new object[] { reached.Count, dispatcher.Waiting });
        // The subscription and the notices: 400 events take one place.
        while (dispatcher.Pump() > 0)
        {
        }
        Program.Say("after", new object[] { reached.Count, reached.First(), reached.Last(), subscription.Dropped });
        Program.Say("threads", threads.Single() == main);
        Program.Say("failures", failures);
        subscription.Dispose();
        navigation.StartAsync().Wait();
        dispatcher.Pump();
        Program.Say("disposed", reached.Count);
        client.CloseAsync().Wait();
        return Task.FromResult(true);
    }
}

/// <summary>Runs wholly in one thread, as in a browser, where there are no others.</summary>
public static class OneThread
{
    public static Task Run(string url)
    {
        int main = Thread.CurrentThread.ManagedThreadId;
        var elsewhere = new List<int>();
        var dispatcher = new Dispatcher(error => { throw error; });
        Stopwatch watch = Stopwatch.StartNew();
        var timing = new PumpedTiming(() => watch.ElapsedMilliseconds);
        var options = new ClientOptions { Callbacks = dispatcher, Work = dispatcher, Timing = timing };
        SynchronizationContext.SetSynchronizationContext(dispatcher);
        Task work = Drive(url, options, () =>
        {
            if (Thread.CurrentThread.ManagedThreadId != main)
            {
                elsewhere.Add(Thread.CurrentThread.ManagedThreadId);
            }
        });
        while (!work.IsCompleted)
        {
            timing.Pump();
            dispatcher.Pump();
            Thread.Yield();
        }
        work.Wait();
        Program.Say("elsewhere", elsewhere);
        return work;
    }

    private static async Task Drive(string url, ClientOptions options, Action check)
    {
        Client client = await Program.Connect(url, options);
        check();
        using (Body body = await client.BodyAsync(new BodyRequest(Navigation.Type)))
        {
            Navigation navigation = body.Part(Navigation.Type);
            var reached = new TaskCompletionSource<string>();
            await navigation.ReachedTarget.SubscribeAsync(told =>
            {
                check();
                reached.TrySetResult(told.Target);
            });
            await navigation.SetAsync(targetPositions: new[] { "lobby" });
            await navigation.StartAsync();
            check();
            Program.Say("reached", await reached.Task);
        }
        await client.CloseAsync();
    }
}
