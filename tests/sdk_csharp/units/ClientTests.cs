using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading.Tasks;
using Newtonsoft.Json.Linq;
using OpenRoIS;

public static class ConnectionTests
{
    public static async Task ALostConnectionIsMadeAgainAfterAWaitThatTheGatewayAsksFor()
    {
        var place = new Place();
        await place.Client.ConnectAsync();
        await place.Gateway.Socket.CloseAsync(1012, "retry_after=5");
        ConnectionChange waiting = await place.Next(ConnectionState.Waiting);
        Check.Equal("the connection ended: retry_after=5 (1012)", waiting.Reason);
        Check.True(waiting.RetryIn >= TimeSpan.FromSeconds(5), "it waits as long as it was asked to");
        Check.True(waiting.RetryIn <= TimeSpan.FromSeconds(5.5), "and by chance a little longer");
        await place.AdvanceTo(6000, ConnectionState.Connected);
        Check.Equal(2, place.Gateway.Opened);
        await place.Client.CloseAsync();
        Check.Equal(ConnectionState.Closed, place.Client.State);
    }

    public static async Task ARefusalThatIsFinalEndsAllAttempts()
    {
        var place = new Place();
        await place.Client.ConnectAsync();
        place.Gateway.Refuse(new ConnectionFailedException("no network"));
        place.Gateway.Refuse(new ConnectionFailedException("not any more", true));
        place.Gateway.Socket.Break();
        await place.Next(ConnectionState.Waiting);
        await place.AdvanceTo(10000, ConnectionState.Waiting);
        await place.AdvanceTo(20000, ConnectionState.Closed);
        ConnectionLostException over = await Check.ThrowsAsync<ConnectionLostException>(() => place.Client.SearchAsync());
        Check.True(over.Message.Contains("not any more"), over.Message);
    }

    public static async Task AFirstAttemptThatFailsMayBeRepeated()
    {
        var place = new Place();
        place.Gateway.Refuse(new ConnectionFailedException("nobody there"));
        await Check.ThrowsAsync<ConnectionFailedException>(() => place.Client.ConnectAsync());
        await place.Client.ConnectAsync();
        Check.Equal(ConnectionState.Connected, place.Client.State);
        await Check.ThrowsAsync<InvalidOperationException>(() => place.Client.ConnectAsync());
        await place.Client.CloseAsync();
    }

    public static async Task AGatewayThatDoesNotAnswerIsGivenUp()
    {
        var place = new Place();
        place.Gateway.Answers.Remove("rois.system.connect");
        Task connecting = place.Client.ConnectAsync();
        await place.Gateway.RequestAsync("rois.system.connect");
        place.Clock.Advance(10000);
        ConnectionFailedException error = await Check.ThrowsAsync<ConnectionFailedException>(() => connecting);
        Check.Equal("the gateway did not answer within 10000 ms", error.Message);
    }

    public static async Task ASilentGatewayIsAskedForASignOfLife()
    {
        var place = new Place();
        await place.Client.ConnectAsync();
        await place.Client.CallAsync(Methods.SystemConnect, new NoParams());
        await place.Settle();
        place.Clock.Advance(20000);
        JObject probe = await place.Gateway.RequestAsync("rois.command.search");
        // Nothing comes: the connection is dead, though no system has said so.
        place.Clock.Advance(30000);
        ConnectionChange waiting = await place.Next(ConnectionState.Waiting);
        Check.True(waiting.Reason.Contains("no answer"), waiting.Reason);
        Check.True(probe != null, "it was asked");
    }

    public static async Task AQuestionWaitsForTheNextConnectionAndACommandDoesNot()
    {
        var place = new Place();
        await place.Client.ConnectAsync();
        Task<IReadOnlyList<string>> searching = place.Client.SearchAsync();
        await place.Gateway.RequestAsync("rois.command.search");
        place.Gateway.Socket.Break();
        await place.Next(ConnectionState.Waiting);
        ConnectionLostException error = await Check.ThrowsAsync<ConnectionLostException>(
            () => new Step(place.Client, "robot/lamp", "start").RunAsync());
        Check.True(error.Message.Contains("commands are not kept for later"), error.Message);
        await place.AdvanceTo(10000, ConnectionState.Connected);
        JObject again = await place.Gateway.RequestAsync("rois.command.search");
        place.Gateway.Answer(again, ScriptedGateway.Ok(new JProperty("component_ref_list", new JArray("robot/lamp"))));
        Check.Equal("robot/lamp", (await searching).Single());
        await place.Client.CloseAsync();
    }

    public static async Task ABindingThatComesTooLateIsReleased()
    {
        var place = new Place();
        await place.Client.ConnectAsync();
        using (var soon = new System.Threading.CancellationTokenSource())
        {
            Task binding = place.Client.BindAsync("robot/lamp", soon.Token);
            JObject bind = await place.Gateway.RequestAsync("rois.command.bind");
            soon.Cancel();
            await Check.ThrowsAsync<OperationCanceledException>(() => binding);
            place.Gateway.Answer(bind, ScriptedGateway.Ok());
            JObject release = await place.Gateway.RequestAsync("rois.command.release");
            Check.Equal("robot/lamp", (string)release["params"]["component_ref"]);
        }
        await place.Client.CloseAsync();
    }

    public static async Task ACommandWhoseEndNeverComesIsGivenUpAfterAWhile()
    {
        var place = new Place();
        Command command = await Running(place);
        for (int number = 0; number < 9; number++)
        {
            place.Gateway.Refuse(new ConnectionFailedException("no network"));
        }
        place.Gateway.Socket.Break();
        await place.Next(ConnectionState.Waiting);
        Task<string> thrown = Thrown(command.WaitAsync());
        place.Clock.Advance(29999);
        await place.Settle();
        Check.True(!thrown.IsCompleted, "the gateway may be back yet");
        place.Clock.Advance(1);
        Check.True((await thrown).StartsWith("start of robot/lamp: the connection ended: "), await thrown);
    }

    public static async Task TheEndOfACommandAtAGatewayThatMayBeLostIsAskedForAgain()
    {
        foreach (int looks in new[] { 0, 3, 99 })
        {
            var place = new Place();
            Command command = await Running(place);
            place.Gateway.Answers["openrois.lease.resume"] = given => Code("UNSUPPORTED");
            int asked = 0;
            place.Gateway.Answers["rois.command.get_command_result"] = given => Code(++asked <= looks ? "TIMEOUT" : "ERROR");
            place.Gateway.Socket.Break();
            await place.Next(ConnectionState.Waiting);
            Task<string> thrown = Thrown(command.WaitAsync());
            await place.AdvanceTo(1000, ConnectionState.Connected);
            string wanted = looks < 99 ? "never arrived" : "it may still run at another gateway";
            Check.True((await thrown).Contains(wanted), await thrown);
            Check.Equal(looks < 99 ? looks + 2 : 6, asked);
            await place.Client.CloseAsync();
        }
    }

    public static async Task AConnectionThatWasClosedAsSilentOrForARestartIsResumed()
    {
        foreach (int code in new[] { 1006, 1011, 1012, 4000 })
        {
            var place = new Place();
            Command command = await Running(place);
            string shown = null;
            place.Gateway.Answers["openrois.lease.resume"] = given =>
            {
                shown = (string)given["token"];
                return ScriptedGateway.Ok(new JProperty("token", "u"), new JProperty("grace_ms", 10000));
            };
            await place.Gateway.Socket.CloseAsync(code, "no answer");
            await place.Next(ConnectionState.Waiting);
            await place.AdvanceTo(1000, ConnectionState.Connected);
            Check.Equal("t", shown);
            place.Gateway.Notify("rois.command.completed", new JObject(
                new JProperty("command_id", command.CommandId), new JProperty("status", "OK")));
            await command.WaitAsync();
            await place.Client.CloseAsync();
        }
    }

    /// <summary>A command that was accepted.</summary>
    private static async Task<Command> Running(Place place)
    {
        await place.Client.ConnectAsync();
        Task<Command> sending = new Step(place.Client, "robot/lamp", "start").ExecuteAsync();
        place.Gateway.Answer(await place.Gateway.RequestAsync("rois.command.execute"), ScriptedGateway.Ok());
        return await sending;
    }

    private static JObject Code(string code)
    {
        return new JObject(new JProperty("return_code", code));
    }

    private static async Task<string> Thrown(Task waiting)
    {
        return (await Check.ThrowsAsync<ConnectionLostException>(() => waiting)).Message;
    }
}

public static class TokenTests
{
    public static void ATokenIsOneLineOfPrintableText()
    {
        Check.Equal("abc.def", Tokens.Read(() => " abc.def\r\n"));
        foreach (string wrong in new[] { null, "", "  ", "a b", "a\nb", "schön" })
        {
            ConnectionFailedException error = Check.Throws<ConnectionFailedException>(() => Tokens.Read(() => wrong));
            Check.True(wrong == null || wrong.Trim() == "" || !error.Message.Contains(wrong), "it is not repeated");
        }
        Check.Throws<ConnectionFailedException>(() => Tokens.Read(() => { throw new FormatException("no file"); }));
    }

    public static void ConditionsAreQuoted()
    {
        Check.Equal("component_ref = 'a''b' AND component_type = 'urn:x'", Condition.And(
            Condition.ComponentRef("a'b"), "", null, Condition.ComponentType("urn:x")));
        Check.Equal("component_ref LIKE 'avatar/%'", Condition.ComponentRefLike("avatar/%"));
        Check.Throws<ArgumentNullException>(() => Condition.ComponentRef(null));
    }
}
