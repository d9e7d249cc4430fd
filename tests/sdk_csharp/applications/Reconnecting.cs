// Applications whose connection, robot or gateway goes away and comes back.
using System;
using System.Linq;
using System.Threading.Tasks;
using OpenRoIS;
using OpenRoIS.Components;

/// <summary>Binds, subscribes and stays: what comes and goes around it is said.</summary>
public static class Keeper
{
    public static async Task Run(string url)
    {
        Client client = await Program.Connect(url);
        client.BindingLost += loss => Program.Say("lost", new[] { "binding", loss.Error.GetType().Name });
        client.SubscriptionLost += loss => Program.Say("lost", new[] { "subscription", loss.Error.GetType().Name });
        client.BindingRestored += componentRef => Program.Say("restored", new[] { "binding" });
        client.SubscriptionRestored += change => Program.Say("restored", new[] { "subscription" });
        client.ConnectionChanged += change =>
        {
            if (change.State == ConnectionState.Connected)
            {
                Program.Say("connected", null);
            }
        };
        Navigation navigation = client.Component(Navigation.Type, "robot/navigation");
        await navigation.BindAsync();
        await navigation.SetAsync(targetPositions: new[] { "lobby" });
        await navigation.ReachedTarget.SubscribeAsync(reached => Program.Say("reached", reached.Target));
        Program.Say("ready", null);
        for (int round = 0; round < 3; round++)
        {
            await Program.Told();
            await navigation.SetAsync(targetPositions: new[] { "place " + round });
            await navigation.StartAsync();
        }
        await Program.Told();
        await client.CloseAsync();
    }
}

/// <summary>Has commands running when the gateway crashes, and says how each of them has ended.</summary>
public static class Survivor
{
    public static async Task Run(string url)
    {
        const string lamp = "robot/lamp";
        Client client = await Program.Connect(url);
        while (!(await client.SearchAsync()).Contains(lamp))
        {
        }
        await client.BindAsync(lamp);
        Execution execution = await client.ExecuteAsync(new Step(client, lamp, "start"), new Step(client, lamp, "switch"));
        Program.Say("ready", null);
        var ends = new string[2][];
        for (int index = 0; index < ends.Length; index++)
        {
            string thrown = await Program.Thrown(() => execution.Commands[index].WaitAsync());
            ends[index] = new[] { thrown, (execution.Commands[index].Error as RoISException)?.Reason };
        }
        Program.Say("ended", ends);
        await client.CloseAsync();
    }
}

/// <summary>Loses its connection while a command runs, and resumes the session with it.</summary>
public static class Resumer
{
    public static async Task Run(string url)
    {
        const string lamp = "robot/lamp";
        Client client = await Program.Connect(url);
        client.BindingLost += loss => Program.Say("lost", loss.ComponentRef);
        client.ConnectionChanged += change => Program.Say("state", change.State.ToString());
        await client.BindAsync(lamp);
        Command running = await new Step(client, lamp, "start").ExecuteAsync();
        Program.Say("ready", null);
        await Program.Told();
        // A question waits for the next connection.
        LeaseStatus lease = await client.Control.StatusAsync(lamp);
        Program.Say("lease", lease.State.ToString());
        Program.Say("running", running.Status == null && running.Error == null);
        await Program.Told();
        await running.WaitAsync();
        Program.Say("ended", running.Status.ToString());
        await client.CloseAsync();
    }
}

/// <summary>Shows tokens: at each connection the newest, and one on the way.</summary>
public static class Bearer
{
    public static async Task Run(string url)
    {
        string[] tokens = Environment.GetEnvironmentVariable("TOKENS").Split(' ');
        var second = new TaskCompletionSource<bool>();
        int shown = 0;
        var options = new ClientOptions
        {
            Token = () =>
            {
                shown++;
                if (shown == 2)
                {
                    second.TrySetResult(true);
                }
                // With the line end that it has in a file.
                return tokens[Math.Min(shown, tokens.Length) - 1] + "\n";
            }
        };
        Program.Say("none", await Program.Thrown(() => new Client(url).ConnectAsync()));
        Program.Say("empty", await Program.Thrown(
            () => new Client(url, new ClientOptions { Token = () => " " }).ConnectAsync()));
        Client client = await Program.Connect(url, options);
        Program.Say("connected", shown);
        await second.Task;
        // Behind the token: it is taken when this is answered.
        await client.SearchAsync();
        Program.Say("renewed", shown);
        await Program.Told();
        await client.SearchAsync();
        Program.Say("again", shown);
        await client.CloseAsync();
    }
}
