// Every operation and every kind of message, once, on a robot with all basic components.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading.Tasks;
using OpenRoIS;
using OpenRoIS.Components;

public static class Tour
{
    public static async Task Run(string url)
    {
        Client client = await Program.Connect(url);
        Program.Say("connected", client.Extensions.OrderBy(each => each));
        ProfileResult profile = await client.GetProfileAsync();
        Program.Say("profile", new object[]
        {
            profile.Profile.SubProfiles.Select(engine => engine.Identifier.Code), profile.ComponentProfiles.Count
        });
        await FindAndDrive(client);
        await Sense(client);
        await Speak(client);
        await Stop(client);
        await Sequence(client);
        await Fault(client);
        await client.CloseAsync();
        Program.Say("closed", client.State.ToString());
    }

    private static async Task FindAndDrive(Client client)
    {
        Navigation navigation = await client.FindAsync(Navigation.Type);
        Program.Say("found", navigation.ComponentRef);
        Program.Say("own", (await navigation.GetProfileAsync()).Name);
        await navigation.BindAsync();
        await navigation.SetAsync(targetPositions: new[] { "lobby", "café 'n'" }, timeLimit: 60000);
        NavigationParameters parameters = await navigation.GetParametersAsync();
        Program.Say("parameters", new object[]
        {
            parameters.TargetPositions, parameters.TimeLimit, parameters.RoutingPolicy
        });
        using (EventReader<ReachedTarget> reached = await navigation.ReachedTarget.ReadAsync())
        {
            await navigation.StartAsync();
            var passed = new List<string>();
            while (await reached.MoveNextAsync() && !reached.Current.IsFinalTarget)
            {
                passed.Add(reached.Current.Target);
            }
            passed.Add(reached.Current.Target);
            Program.Say("travelled", passed);
        }
        Program.Say("status", (await navigation.ComponentStatusAsync()).ToString());
        await navigation.ReleaseAsync();
    }

    private static async Task Sense(Client client)
    {
        PersonDetection persons = await client.FindAsync(PersonDetection.Type);
        Task<PersonDetected> first = null;
        Subscription subscription = null;
        var detected = new TaskCompletionSource<PersonDetected>();
        subscription = await persons.PersonDetected.SubscribeAsync(told => detected.TrySetResult(told));
        first = detected.Task;
        await persons.StartAsync();
        Program.Say("detected", new object[]
        {
            (await first).Number, (await first).Timestamp.UtcDateTime.ToString("s"), subscription.IsActive
        });
        subscription.Dispose();
    }

    private static async Task Speak(Client client)
    {
        SpeechSynthesis speech = await client.FindAsync(
            SpeechSynthesis.Type, Condition.ComponentRefLike("robot/%"));
        Program.Say("languages", await speech.SynthesizableLanguagesAsync());
        await client.BindAsync(speech.ComponentRef);
        await client.RunAsync(speech.SetStep(speechText: "Hello!", volume: 70), speech.StartStep());
        await client.ReleaseAsync(speech.ComponentRef);
        SystemInformation system = await client.FindAsync(SystemInformation.Type);
        RobotPositionResult position = await system.RobotPositionAsync();
        Program.Say("robot", new object[] { position.PositionData, position.RobotRef.Count });
    }

    private static async Task Stop(Client client)
    {
        string componentRef = await client.BindAnyAsync(Condition.ComponentType(Follow.Urn));
        Follow follow = client.Component(Follow.Type, componentRef);
        await follow.SetAsync(targetObjectRef: "alice", distance: 800);
        Command following = await follow.StartStep().ExecuteAsync();
        await follow.StopAsync();
        string thrown = await Program.Thrown(() => following.WaitAsync());
        Program.Say("followed", new object[] { thrown, following.Status.ToString() });
        await follow.ReleaseAsync();
    }

    private static async Task Sequence(Client client)
    {
        PersonDetection persons = await client.FindAsync(PersonDetection.Type);
        AudioStreaming audio = await client.FindAsync(AudioStreaming.Type);
        var connect = new Step<string>(
            client, audio.ComponentRef, "connect_stream", null, told => told.Value<string>("stream_id", "string"));
        Execution execution = await client.ExecuteAsync(
            persons.StartStep(), new Concurrent(connect, persons.StopStep()) { Delay = TimeSpan.FromMilliseconds(1) });
        await execution.WaitAsync();
        Program.Say("sequence", execution.Commands.Select(each => each.Status.ToString()));
        IReadOnlyList<Result> results = await client.GetCommandResultAsync(execution.Commands[1].CommandId);
        Program.Say("result", results.Select(each => each.Name));
        Program.Say("stream", await connect.RunAsync());
    }

    private static async Task Fault(Client client)
    {
        Task<ErrorNotification> fault = Program.First<ErrorNotification>(take => client.Fault += take);
        Program.Say("ready", null);
        ErrorNotification told = await fault;
        IReadOnlyList<Result> detail = await client.GetErrorDetailAsync(told.ErrorId);
        Program.Say("fault", new object[]
        {
            told.ErrorType.ToString(), detail.First(each => each.Name == "description").Value
        });
    }
}
