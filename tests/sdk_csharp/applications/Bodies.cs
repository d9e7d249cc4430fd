// Applications that reserve bodies, and give up.
using System;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using OpenRoIS;
using OpenRoIS.Components;

/// <summary>Gives up what does not come.</summary>
public static class Impatient
{
    public static async Task Run(string url)
    {
        const string door = "robot/door";
        Client client = await Program.Connect(url);
        Program.Say("ready", null);
        // The bell is another application's.
        await Program.Told();
        using (var soon = new CancellationTokenSource())
        {
            var request = new BodyRequest(new ComponentType<ComponentProxy>(
                "urn:x-rois:def:component:Test::Lamp", (owner, componentRef) => new ComponentProxy(owner, componentRef)));
            request.Wait = TimeSpan.FromMinutes(10);
            Task<Body> waiting = client.BodyAsync(request, soon.Token);
            soon.Cancel();
            Program.Say("body", await Program.Thrown(() => waiting));
        }
        using (var soon = new CancellationTokenSource())
        {
            Command opening = await new Step(client, door, "open").ExecuteAsync();
            Task waiting = opening.WaitAsync(soon.Token);
            Program.Say("opening", null);
            soon.Cancel();
            Program.Say("wait", await Program.Thrown(() => waiting));
            await Program.Told();
            await opening.WaitAsync();
            Program.Say("opened", opening.Status.ToString());
        }
        using (var soon = new CancellationTokenSource())
        {
            Task query = client.QueryAsync("view", Condition.ComponentRef(door), soon.Token);
            Program.Say("asking", null);
            await Program.Told();
            soon.Cancel();
            Program.Say("query", await Program.Thrown(() => query));
        }
        using (var before = new CancellationTokenSource())
        {
            before.Cancel();
            Program.Say("before", await Program.Thrown(() => client.BindAsync("robot/lamp", before.Token)));
        }
        await client.CloseAsync();
    }
}

/// <summary>Two applications that compete.</summary>
public static class Rivals
{
    public static async Task Run(string url)
    {
        Client one = await Program.Connect(url);
        Client other = await Program.Connect(url);
        Body first = await one.BodyAsync(SpeechSynthesis.Type, Reaction.Type);
        Program.Say("first", first.EngineId);
        Program.Say("free", (await other.BodiesAsync()).Select(body => new object[] { body.EngineId, body.IsFree }));
        Program.Say("refs", (await other.BodiesAsync())[0].Refs(Reaction.Type));
        var atOnce = new BodyRequest(Navigation.Type, Reaction.Type) { Wait = TimeSpan.Zero };
        try
        {
            await other.BodyAsync(atOnce);
        }
        catch (OutOfResourcesException error)
        {
            Program.Say("refused", error.Message);
        }
        // Of what was refused nothing is held: the first application gets the rest of the body.
        Body rest = await one.BodyAsync(new BodyRequest(Navigation.Type) { Wait = TimeSpan.Zero });
        Program.Say("rest", rest.Part(Navigation.Type).ComponentRef);
        var optional = new BodyRequest(SpeechRecognition.Type)
        {
            Optional = new ComponentType[] { Reaction.Type, PersonDetection.Type }
        };
        Body partly = await other.BodyAsync(optional);
        bool sees = partly.Find(PersonDetection.Type) != null;
        Program.Say("partly", new object[] { partly.Find(Reaction.Type) == null, sees });
        Program.Say("without", await Program.Thrown(() => Task.Run(() => partly.Part(Reaction.Type))));
        // One that waits gets it when it is given back.
        Task<Body> waiting = other.BodyAsync(new BodyRequest(Navigation.Type, Reaction.Type));
        first.Dispose();
        rest.Dispose();
        Program.Say("waited", (await waiting).EngineId);
        await (await waiting).ReleaseAsync();
        Body again = await one.BodyAsync(new BodyRequest(Reaction.Type) { Wait = TimeSpan.Zero });
        Program.Say("again", again.EngineId);
        await one.CloseAsync();
        Program.Say("over", again.Error.GetType().Name);
        await other.CloseAsync();
    }
}

/// <summary>Loses a body that it has reserved.</summary>
public static class Owner
{
    public static async Task Run(string url)
    {
        Client client = await Program.Connect(url);
        Task<BodyLoss> lost = Program.First<BodyLoss>(take => client.BodyLost += take);
        Body body = await client.BodyAsync(SpeechSynthesis.Type, Navigation.Type);
        Program.Say("has", body.EngineId);
        BodyLoss loss = await lost;
        Program.Say("lost", new object[] { loss.EngineId, loss.Error.GetType().Name, body.Error == loss.Error });
        Program.Say("part", await Program.Thrown(() => body.Part(Navigation.Type).StartAsync()));
        body.Dispose();
        Body another = await client.BodyAsync(new BodyRequest(SpeechSynthesis.Type, Navigation.Type));
        Program.Say("another", another.EngineId);
        await Program.Told();
        await client.CloseAsync();
    }
}

/// <summary>Asks another application for a component.</summary>
public static class Leaser
{
    public static async Task Run(string url)
    {
        Client holder = await Program.Connect(url);
        string reaction = (await holder.FindAsync(Reaction.Type)).ComponentRef;
        Client other = await Program.Connect(url);
        await holder.BindAsync(reaction);
        Program.Say("held", (await other.Control.StatusAsync(reaction)).State.ToString());
        bool grants = false;
        holder.ControlRequested += async asked =>
        {
            if (grants)
            {
                await holder.Control.GrantAsync(asked.RequestId);
            }
            else
            {
                await holder.Control.DeclineAsync(asked.RequestId);
            }
        };
        Task<BindingLoss> lost = Program.First<BindingLoss>(take => holder.BindingLost += take);
        Program.Say("declined", await Program.Thrown(() => other.Control.RequestAsync(reaction)));
        grants = true;
        await other.Control.RequestAsync(reaction);
        Program.Say("granted", (await other.Control.StatusAsync(reaction)).State.ToString());
        Program.Say("lost", (await lost).ComponentRef);
        Program.Say("stopped", await other.Control.StopAllAsync("robot"));
        await other.Control.ReleaseStopAsync("robot");
        Program.Say("handed back nothing", await Program.Thrown(() => other.Control.ReleaseStopAsync("rover")));
        using (var soon = new CancellationTokenSource())
        {
            Task inLine = Program.First<LeaseRequestedNotification>(take => other.ControlRequested += take);
            Task waiting = holder.Control.RequestAsync(reaction, true, soon.Token);
            await Task.WhenAny(waiting, inLine);
            soon.Cancel();
            Program.Say("gave up", await Program.Thrown(() => waiting));
        }
        await other.CloseAsync();
        await holder.CloseAsync();
    }
}

/// <summary>A program lends what it has bound to a person, who gives it back.</summary>
public static class Sharer
{
    public static async Task Run(string url)
    {
        string[] tokens = Environment.GetEnvironmentVariable("TOKENS").Split(' ');
        Client program = await Program.Connect(url, new ClientOptions { Token = () => tokens[0] });
        Client person = await Program.Connect(url, new ClientOptions { Token = () => tokens[1] });
        Navigation navigation = await program.FindAsync(Navigation.Type);
        string legs = navigation.ComponentRef;
        await program.BindAsync(legs);

        Task<BindingLoan> lent = Program.First<BindingLoan>(take => program.BindingLent += take);
        Task<string> restored = Program.First<string>(take => program.BindingRestored += take);
        LeaseStatus lease = await person.Control.BorrowAsync(legs, TimeSpan.FromSeconds(20));
        Program.Say("borrowed", new[] { lease.State.ToString(), lease.Lender, lease.Part });
        BindingLoan loan = await lent;
        bool inTime = loan.ReturnsIn > TimeSpan.Zero && loan.ReturnsIn <= TimeSpan.FromSeconds(20);
        Program.Say("lent", new object[] { loan.ComponentRef, loan.Holder, inTime });
        Program.Say("refused", await Program.Thrown(() => navigation.StartAsync()));
        Program.Say("of higher rank", await Program.Thrown(() => program.Control.BorrowAsync(legs)));
        await person.Control.GiveBackAsync(legs);
        Program.Say("restored", await restored);
        await navigation.SetAsync(targetPositions: new[] { "lobby" });
        await navigation.StartAsync();

        SpeechSynthesis voice = await program.FindAsync(SpeechSynthesis.Type);
        await program.BindAsync(voice.ComponentRef);
        restored = Program.First<string>(take => program.BindingRestored += take);
        await person.Control.BorrowAsync(voice.ComponentRef, forOneCommand: true);
        SpeechSynthesis same = await person.FindAsync(SpeechSynthesis.Type);
        await same.SetAsync(speechText: "Excuse me.");
        await same.StartAsync();
        Program.Say("restored", await restored);
        await voice.SetAsync(speechText: "I go on.");
        await voice.StartAsync();
        await person.CloseAsync();
        await program.CloseAsync();
    }
}
